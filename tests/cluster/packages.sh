#!/usr/bin/env bash
# Installs what a one-node Slurm needs, where that is wanted: as root, on Debian, where no init system would start daemons.
# Prints why not and ends with 1 otherwise.
set -euo pipefail
wanted=(munge slurmctld slurmd slurm-client)
if ((EUID != 0)); then echo "not root"; exit 1; fi
if ! command -v dpkg-query > /dev/null || ! command -v apt-get > /dev/null; then echo "not Debian"; exit 1; fi
missing=()
for package in "${wanted[@]}"; do
    [[ $(dpkg-query -W -f '${db:Status-Status}' "$package" 2> /dev/null || true) == installed ]] || missing+=("$package")
done
if ((${#missing[@]} == 0)); then exit 0; fi
if [[ -d /run/systemd/system ]]; then
    echo "${missing[*]} not there, and installing them here would start daemons: apt-get install them by hand"
    exit 1
fi
export DEBIAN_FRONTEND=noninteractive
quiet=(apt-get -qq -o Dpkg::Use-Pty=0)
"${quiet[@]}" update > /dev/null 2>&1 || true
if ! "${quiet[@]}" install --yes --no-install-recommends "${missing[@]}" > /dev/null 2>&1; then
    echo "${missing[*]} could not be installed"
    exit 1
fi
