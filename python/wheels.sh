#!/bin/sh
# Builds the wheel of the Python package into a folder, `dist` if none is given. One wheel serves all versions of Python from 3.10.
#
# On Linux it is for every distribution with glibc 2.17 or later (manylinux2014), linked with zig (`pip install maturin ziglang`).
# Where zig is missing, it is for this machine's glibc or later, and its file name says so. On macOS and Windows it is a native one.
set -eu
folder=${1:-dist}
cd "$(dirname "$0")"
if [ "$(uname -s)" != Linux ]; then
    maturin build --release --out "$folder"
elif python3 -m ziglang version > /dev/null 2>&1 || command -v zig > /dev/null; then
    maturin build --release --zig --compatibility manylinux2014 --out "$folder"
else
    echo "zig is missing: the wheel is for this machine's glibc or later" >&2
    maturin build --release --compatibility pypi --out "$folder" || maturin build --release --compatibility linux --out "$folder"
fi
