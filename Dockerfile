# An image with `tunenet`, `tunenet-video` and `tunenet-bench`: docker build --tag tunenet .
# Without video, which makes it much smaller: docker build --tag tunenet --build-arg FEATURES=--no-default-features --build-arg LIBRARIES= .

FROM debian:bookworm-slim AS build
RUN apt-get update && apt-get install --yes --no-install-recommends \
        build-essential ca-certificates clang curl libclang-dev libopencv-dev pkg-config \
    && rm -rf /var/lib/apt/lists/*
ENV PATH=/root/.cargo/bin:$PATH
RUN curl --proto '=https' --tlsv1.2 --silent --show-error --fail --output /tmp/rustup-init \
        "https://static.rust-lang.org/rustup/dist/$(uname -m)-unknown-linux-gnu/rustup-init" \
    && chmod +x /tmp/rustup-init && /tmp/rustup-init -y --profile minimal --default-toolchain none && rm /tmp/rustup-init
WORKDIR /source
COPY . .
ARG FEATURES=
# rust-toolchain.toml names the version, which rustup then brings.
RUN rustup toolchain install && cargo install --locked --path crates/tunenet-cli --root /opt/tunenet $FEATURES \
    && cargo install --locked --path crates/tunenet-bench --root /opt/tunenet $FEATURES

FROM debian:bookworm-slim
ARG LIBRARIES="libopencv-imgcodecs406 libopencv-imgproc406 libopencv-videoio406"
RUN if [ -n "$LIBRARIES" ]; then \
        apt-get update && apt-get install --yes --no-install-recommends $LIBRARIES && rm -rf /var/lib/apt/lists/*; \
    fi
COPY --from=build /opt/tunenet/bin/ /usr/local/bin/
# Recordings come in and answers go out here; networks made for a scene are kept in the cache.
WORKDIR /data
ENV TUNENET_CACHE=/tmp/tunenet
ENTRYPOINT ["tunenet"]
