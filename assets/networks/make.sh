#!/usr/bin/env bash
# Makes the built-in network again: simulated recordings, prepared as real ones are, then the training. Takes about a minute.
set -euo pipefail
cd "$(dirname "$0")/../.."
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cargo build --release --package tunenet-cli --no-default-features --quiet
target/release/tunenet gen ball --preset general --pairs 10000 --seed 0 --out "$folder/drawn.mcap"
target/release/tunenet train --data "$folder/drawn.mcap" --preset general --seed 0 --out "$folder/ball.safetensors"
mv "$folder/ball.safetensors" assets/networks/ball.safetensors
echo 'wrote    assets/networks/ball.safetensors; build again to have it built in'
