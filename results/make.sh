#!/usr/bin/env bash
# Measures again what this folder holds, and pastes it into the pages that show it:
#     results/make.sh [paper|shot|diagnose|arm|driven|law|joints|recorded|intervals|regions|rollouts|preflight|grow|speed]…
# Each takes minutes; all but `speed`, `rollouts`, `recorded` and `grow` resume where they were stopped. Nothing else should run at the same
# time as these four. `recorded` needs TUNENET_MEASURED, a folder of recordings that others made.
set -euo pipefail
cd "$(dirname "$0")/.."
export PATH="$PATH:$HOME/.cargo/bin"

# Seeds that nothing else in this repository uses, so that nothing was fitted to them.
seed=${SEED:-90211}
shot_seed=${SEED:-31871} # other balls than those of figure 3
tool=${CARGO_TARGET_DIR:-target}/release/tunenet

if [[ -n $(git status --porcelain) ]]; then
    echo "results name the commit they were made at: commit or stash what is changed first" >&2
    exit 1
fi
commit=$(git rev-parse HEAD)
cargo build --release --workspace --quiet

paste() { # NAME PAGE FILE: the file's text between the page's marks of that name
    awk -v name="$1" -v file="$3" '
        $0 == "<!-- " name ": begin -->" { print; while ((getline line < file) > 0) print line; skip = 1 }
        $0 == "<!-- " name ": end -->" { skip = 0 }
        !skip { print }' "$2" > "$2.new"
    mv "$2.new" "$2"
}

body() { # FILE: without its title and the command below it, which the page has in its own words
    sed -e '1,/^    tunenet /d' "$1" | sed -e '/./,$!d' -e 's/^## /### /'
}

measure() { # NAME COMMAND…: runs it and notes how
    local name=$1 began=$SECONDS folder=results/$1
    shift
    mkdir -p "$folder" target/results
    "$tool" "$@" --out "target/results/$name" > "target/results/$name.txt"
    for file in target/results/"$name"/*.{md,csv,json,svg}; do
        # What is given for every single drop is too much to keep here.
        if [[ -f $file ]] && (($(stat -c %s "$file") < 200000)); then
            cp "$file" "$folder/"
        fi
    done
    note "$folder" "tunenet $*" $((SECONDS - began))
}

listen() { # NAME COMMAND…: as `measure`, and keeps what it prints on standard output
    local name=$1
    measure "$@"
    sed -e '/./,$!d' "target/results/$name.txt" > "results/$name/printed.md"
}

fenced() { # FILE: as it stands
    printf '```text\n%s\n```\n' "$(cat "$1")"
}

note() { # FOLDER COMMAND SECONDS
    {
        echo "commit  $commit"
        echo "command $2"
        echo "machine $(nproc) cores of $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1)"
        echo "seconds $3 (less where a stopped run went on)"
    } > "$1/run.txt"
}

for what in "${@:-paper}"; do
    case $what in
        paper)
            measure paper bench paper --seed "$seed"
            cp results/paper/figure2.svg results/paper/figure3.svg docs/
            for part in table1 table2 table3 figure2 figure3; do
                paste "$part" docs/paper.md <(body "results/paper/$part.md")
            done
            ;;
        grow)
            measure grow bench grow --pairs 1000 10000 100000 1000000 --threads 2 --want 100000000 --nodes 16 --cores 32
            paste grow docs/grow.md results/grow/grow.md
            ;;
        shot)
            measure shot bench shot --trials 200 --seed "$shot_seed"
            paste shot docs/evidence-shot.md <(body results/shot/shot.md)
            ;;
        diagnose)
            measure diagnose bench diagnose --seed "$seed"
            paste goals docs/evidence.md <(body results/diagnose/goals.md)
            ;;
        arm)
            listen arm bench diagnose --arm --seed "$seed"
            paste arm docs/evidence.md <(fenced results/arm/printed.md)
            ;;
        driven)
            measure driven bench diagnose --driven --seed "$seed"
            paste driven docs/evidence.md <(body results/driven/goals.md)
            ;;
        law)
            measure law bench law --sets 6 --seed "$seed"
            paste law docs/evidence.md <(body results/law/goals.md)
            ;;
        joints)
            measure joints bench joints --sets 6 --seed "$seed"
            paste joints docs/evidence.md <(body results/joints/goals.md)
            ;;
        recorded)
            measure recorded bench recorded
            paste recorded docs/evidence.md <(body results/recorded/recorded.md)
            ;;
        intervals)
            listen intervals bench intervals --seed "$seed"
            paste intervals docs/evidence.md <(fenced results/intervals/printed.md)
            ;;
        regions)
            measure regions bench regions --draws 400 --seed "$seed"
            paste regions docs/evidence.md <(body results/regions/regions.md)
            ;;
        rollouts)
            measure rollouts bench rollouts --seed "$seed"
            paste rollouts docs/evidence.md <(body results/rollouts/rollouts.md)
            ;;
        preflight)
            listen preflight bench preflight --seed "$seed"
            paste preflight docs/evidence.md results/preflight/printed.md
            ;;
        speed)
            mkdir -p results/speed target
            began=$SECONDS
            "$tool" bench speed --json > results/speed/speed.json 2> target/results-speed.txt
            # Two columns, far apart, below the line of each stage.
            {
                printf '| what | figure |\n|---|---|\n'
                sed -nE 's/^  (.*[^ ])  +([^ ].*)$/| \1 | \2 |/p' target/results-speed.txt
            } > results/speed/speed.md
            note results/speed "tunenet bench speed" $((SECONDS - began))
            paste speed docs/evidence.md results/speed/speed.md
            ;;
        *)
            echo "expected one of those at the head of this file, found \`$what\`" >&2
            exit 2
            ;;
    esac
    echo "==> results/$what at $commit"
done
