#!/usr/bin/env bash
# From a recording to a tuned simulation. Needs only cargo and a C compiler. Run by `make demo`.
# With TOOL=FILE in the environment, that executable is used and nothing is built.
set -euo pipefail
cd "$(dirname "$0")/.."
target="${CARGO_TARGET_DIR:-target}"
out="$target/demo"
tool="${TOOL:-$target/demo-build/tunenet}"

say() { printf '\n\033[1m%s\033[0m\n' "$*" | if [[ -t 1 ]]; then cat; else sed 's/\x1b\[[0-9]*m//g'; fi; }
run() { # shows a command as a user would type it, then runs it
    printf '$ tunenet %s\n' "$*"
    "$tool" "$@"
}

if [[ -z "${TOOL:-}" ]]; then
    # A build that optimises less takes two thirds of the time, and what is shown here runs for seconds.
    say "Building tunenet without video"
    cargo build --profile demo-build -p tunenet-cli --no-default-features
fi
# Files written by an older version may not be recognised as tunenet's.
rm -rf "$out"
mkdir -p "$out"

say "1. A ball was dropped from about 1 m and recorded. What is in the file?"
run inspect assets/observations/drop.csv

say "2. What is its restitution? Release and floor are not known: they are estimated as well."
run tune --sim assets/ball.toml assets/observations/drop.csv --out "$out/tuned.toml"
echo "(synthetic, from an independent simulator: restitution 0.83, noise 2 mm)"

say "3. The tuned simulation is a text file."
sed -n '/^\[parameters.restitution\]/,/^$/p; /^\[provenance\]/,$p' "$out/tuned.toml"

say "4. It predicts other drops, for example from 2 m."
run simulate --sim "$out/tuned.toml" --set release.height_m=2.0 --out "$out/from_2_m.csv"
head -n 4 "$out/from_2_m.csv"

say "5. The same from bounce times only, as a microphone records them."
run tune --sim assets/ball.toml assets/observations/bounces.csv --out "$out/tuned_by_ear.toml"
echo "(synthetic: restitution 0.9, noise 0.2 ms)"

say "6. A light ball was thrown five times, and no restitution fits. Which effect is missing?"
run diagnose --sim assets/ball.toml assets/observations/light_[1-4].csv \
    --held-out assets/observations/light_5.csv --out "$out/improved.toml" --report "$out/improved.html"
echo "(synthetic: drag 0.1317 1/m, a drag coefficient of 0.47)"

say "7. The simulation file now contains the effect and the evidence for it."
sed -n '/^\[effects/,/^$/p; /^\[provenance\]/,$p' "$out/improved.toml"

say "Done. The files are here:"
ls -1 "$out"/*.toml "$out"/*.csv
echo "The diagnosis as an HTML report: $out/improved.html"
