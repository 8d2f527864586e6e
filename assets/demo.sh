#!/usr/bin/env bash
# From a recording to a simulation that behaves like it. Needs cargo and a C compiler only. Run by `make demo`.
set -euo pipefail
cd "$(dirname "$0")/.."
target="${CARGO_TARGET_DIR:-target}"
out="$target/demo"
tool="$target/release/tunenet"

say() { printf '\n\033[1m%s\033[0m\n' "$*" | if [[ -t 1 ]]; then cat; else sed 's/\x1b\[[0-9]*m//g'; fi; }
run() { # shows a command as a person would type it, then runs it
    printf '$ tunenet %s\n' "$*"
    "$tool" "$@"
}

say "Building tunenet without video"
cargo build --release -p tunenet-cli --no-default-features
# What an older version wrote may look like nobody's to this one.
rm -rf "$out"
mkdir -p "$out"

say "1. A ball was dropped from about 1 m and recorded. What is in the file?"
run inspect assets/observations/drop.csv

say "2. How does it bounce? The release and the floor are not known: they are estimated as well."
run tune --sim assets/ball.toml --observation assets/observations/drop.csv --out "$out/tuned.toml"
echo "(another program made this recording, with a restitution of 0.83 and 2 mm of noise)"

say "3. The tuned simulation is a file to read, to edit and to keep."
sed -n '/^\[parameters.restitution\]/,/^$/p; /^\[provenance\]/,$p' "$out/tuned.toml"

say "4. It now predicts drops that nobody recorded: one from 2 m."
run simulate --sim "$out/tuned.toml" --set release.height_m=2.0 --out "$out/from_2_m.csv"
head -n 4 "$out/from_2_m.csv"

say "5. A microphone is enough: the same from the times of the bounces alone."
run tune --sim assets/ball.toml --observation assets/observations/bounces.csv --out "$out/tuned_by_ear.toml"
echo "(this one was made with a restitution of 0.9 and 0.2 ms of noise)"

say "6. A light ball was thrown five times. Tuning alone does not make the simulation follow: what is missing?"
run diagnose --sim assets/ball.toml --observation assets/observations/light_[1-4].csv \
    --held-out assets/observations/light_5.csv --out "$out/improved.toml" --report "$out/improved.html"
echo "(the other program has air in it: drag of 0.1317 1/m, a drag coefficient of 0.47)"

say "7. The simulation file has the effect now, and says on what evidence."
sed -n '/^\[effects/,/^$/p; /^\[provenance\]/,$p' "$out/improved.toml"

say "Done. The files are here:"
ls -1 "$out"/*.toml "$out"/*.csv
echo "What is missing, on what evidence, and what changed, as a page for a browser: $out/improved.html"
