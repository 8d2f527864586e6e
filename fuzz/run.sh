#!/usr/bin/env bash
# Runs a fuzz target until it has seen enough: `fuzz/run.sh TARGET EXECUTIONS [SECONDS]`.
#
# Coverage is counted, and more than 1 GB is a fault. Address checks are left out: no crate here holds `unsafe`, so the stable
# toolchain will do. `cargo +nightly fuzz run TARGET` runs the same targets with them.
set -euo pipefail
cd "$(dirname "$0")"
target=$1 executions=$2 seconds=${3:-0}
export CARGO_TARGET_DIR=${FUZZ_TARGET_DIR:-$PWD/../target/fuzz}
triple=$(rustc -vV | sed -n 's/^host: //p')
# What cargo-fuzz gives the compiler, less the sanitizer.
export RUSTFLAGS="--cfg fuzzing -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
-Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
-Cllvm-args=-sanitizer-coverage-trace-compares -Ccodegen-units=1"
cargo build --release --target "$triple" --bins ${JOBS:+-j "$JOBS"}
mkdir -p "grown/$target" "artifacts/$target"
exec "$CARGO_TARGET_DIR/$triple/release/$target" -runs="$executions" -max_total_time="$seconds" -max_len=16384 -timeout=10 \
    -rss_limit_mb=1024 -artifact_prefix="artifacts/$target/" -print_final_stats=1 -verbosity=0 "grown/$target" "corpus/$target"
