#!/usr/bin/env bash
# assets/cluster/indexed-job.yaml against the schemas of Kubernetes; and a Job that is none, to see that they look.
#
#   tests/cluster/kubernetes.sh VALIDATOR
set -euo pipefail
validator=$1
job=$(realpath "$(dirname "$0")/../../assets/cluster/indexed-job.yaml")
root=$(mktemp -d)
trap 'rm -rf "$root"' EXIT
sed 's/completions: 4/completions: four/' "$job" > "$root/bad.yaml"
for version in 1.28 1.31 1.34; do
    "$validator" --strict --quiet -k "$version" "$job"
    if "$validator" --strict --quiet -k "$version" "$root/bad.yaml" > /dev/null 2>&1; then
        echo "the validator takes anything" >&2
        exit 1
    fi
done
# What is asked of the command line is that it can be read: the pods run it as it stands.
grep -q 'completionMode: Indexed' "$job"
echo "Kubernetes 1.28, 1.31, 1.34: the Indexed Job is valid"
