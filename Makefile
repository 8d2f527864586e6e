# What people and machines type. `make help` lists it.

# rustup's cargo, also where a shell has not been told of it.
export PATH := $(PATH):$(HOME)/.cargo/bin
SHELL := /bin/bash
.SHELLFLAGS := -euo pipefail -c
.DEFAULT_GOAL := help

# What building with video needs on Debian and Ubuntu.
PACKAGES := libopencv-dev clang libclang-dev pkg-config

# Tools that are not needed to build, at the versions that were tried.
MDBOOK := 0.5.4
CARGO_DENY := 0.20.2

# The tool that `test-mcap`, `test-slurm` and `demo` use: one that is there already, or else one that they build without video.
TOOL :=
BUILT = $(or $(TOOL),$${CARGO_TARGET_DIR:-target}/release/tunenet)

.PHONY: help test test-mcap test-slurm build demo book licences model fmt packages mcap-packages judges cargo

help: ## list these targets
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):.*## /  make \1\t/' | expand -t 18

test: packages ## install what is missing, then check format, lints, tests, doctests and documentation
	@echo "==> format"
	@cargo fmt --all --check
	@echo "==> lints"
	@cargo clippy --workspace --all-targets --quiet -- -D warnings
	@echo "==> tests and doctests"
	@cargo test --workspace --no-fail-fast --quiet
	@echo "==> documentation"
	@RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --quiet
	@echo "==> all hold"

test-mcap: mcap-packages cargo ## read what simulate, gen and plan write with the Python packages mcap and mcap-ros2-support
	@echo "==> MCAP read by others"
	@[[ -n "$(TOOL)" ]] || cargo build --release -p tunenet-cli --no-default-features --quiet
	@target/mcap-venv/bin/python tests/mcap/check.py $(BUILT)

test-slurm: cargo ## run shards on a one-node Slurm, on a local Ray, and check the Kubernetes manifest; says what it skips and why
	@echo "==> shards on engines that people run"
	@[[ -n "$(TOOL)" ]] || cargo build --release -p tunenet-cli --no-default-features --quiet
	@if why=$$(tests/cluster/packages.sh); then \
	    tests/cluster/slurm.sh $(BUILT); \
	else \
	    echo "Slurm: skipped, $$why"; \
	fi
	@if why=$$($(MAKE) --silent target/cluster-venv/ready 2>&1); then \
	    tests/cluster/ray.sh $(BUILT) target/cluster-venv/bin/python && \
	    tests/cluster/kubernetes.sh target/cluster-venv/bin/kubernetes-validate; \
	else \
	    echo "Ray, Kubernetes: skipped, $$(tail -n 1 <<< "$$why")"; \
	fi

build: packages ## build the executables with video into target/release
	@echo "==> release build with video"
	@cargo build --release --workspace

demo: cargo ## build without video, then inspect, tune and simulate with ready observations
	@TOOL="$(TOOL)" assets/demo.sh

book: target/tools/bin/mdbook ## build docs/ as a book into target/book
	@$< build docs

licences: target/tools/bin/cargo-deny ## check licences, sources and bans of every dependency (deny.toml)
	@$< --workspace check licenses bans sources
	@sha256sum Cargo.lock deny.toml > .ci/licences.sha256

model: cargo ## train the built-in network again
	@assets/networks/make.sh

fmt: cargo ## format all code
	@cargo fmt --all

# Nothing happens, and nobody is asked for a password, where everything is there.
packages: cargo
	@if ! command -v dpkg-query > /dev/null; then \
	    if pkg-config --exists opencv4 2> /dev/null && command -v clang > /dev/null; then exit 0; fi; \
	    echo 'OpenCV or clang is missing, and this is not Debian or Ubuntu: install OpenCV 4 with its headers, clang, libclang and pkg-config, or run "make demo", which needs none of them' >&2; \
	    exit 1; \
	fi; \
	missing=(); \
	for package in $(PACKAGES); do \
	    [[ "$$(dpkg-query -W -f '$${db:Status-Status}' "$$package" 2> /dev/null || true)" == installed ]] || missing+=("$$package"); \
	done; \
	if (( $${#missing[@]} == 0 )); then exit 0; fi; \
	echo "==> install $${missing[*]}"; \
	if ! command -v apt-get > /dev/null; then echo "apt-get is not there: install $${missing[*]} by hand" >&2; exit 1; fi; \
	root=(); \
	if (( EUID != 0 )); then \
	    if ! command -v sudo > /dev/null; then echo "sudo is not there: as root, run apt-get install $${missing[*]}" >&2; exit 1; fi; \
	    root=(sudo); \
	fi; \
	quiet=("$${root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qq -o Dpkg::Use-Pty=0); \
	"$${quiet[@]}" update > /dev/null && "$${quiet[@]}" install --yes --no-install-recommends "$${missing[@]}" > /dev/null

# The only things here that ask a package index for something; nothing else needs them.
mcap-packages: target/mcap-venv/ready

target/mcap-venv/ready: tests/mcap/requirements.txt
	@python3 -m venv target/mcap-venv || { echo 'Python cannot make a virtual environment: install python3-venv' >&2; exit 1; }
	@target/mcap-venv/bin/pip install --quiet --disable-pip-version-check --retries 1 --timeout 20 -r $<
	@touch $@

target/cluster-venv/ready: tests/cluster/requirements.txt
	@python3 -m venv target/cluster-venv || { echo 'Python cannot make a virtual environment: install python3-venv' >&2; exit 1; }
	@target/cluster-venv/bin/pip install --quiet --disable-pip-version-check --retries 1 --timeout 20 -r $<
	@touch $@

# Python with MuJoCo, which judges driven simulators in the tests, and with what writes logs in every format; its folder bin has to come first in PATH.
judges: target/judges-venv/ready

target/judges-venv/ready: tests/process/requirements.txt
	@python3 -m venv target/judges-venv || { echo 'Python cannot make a virtual environment: install python3-venv' >&2; exit 1; }
	@target/judges-venv/bin/pip install --quiet --disable-pip-version-check --retries 1 --timeout 20 -r $<
	@touch $@

# Tools are compiled once, about a minute each, and kept where the build is.
target/tools/bin/mdbook: | cargo
	@cargo install --quiet --locked --root target/tools --no-default-features --version $(MDBOOK) mdbook

target/tools/bin/cargo-deny: | cargo
	@cargo install --quiet --locked --root target/tools --no-default-features --version $(CARGO_DENY) cargo-deny

cargo:
	@command -v cargo > /dev/null || { echo 'cargo is not there: install Rust with rustup (https://rustup.rs)' >&2; exit 1; }
	@command -v cc > /dev/null || { echo 'a C compiler is not there: run "apt-get install build-essential" (Debian, Ubuntu)' >&2; exit 1; }
