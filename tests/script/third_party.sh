#!/bin/bash
# third_party.sh: script/third-party takes the notices of source packages on its list alone, and wasm/join puts them into the page.
set -eu
cd "$(dirname "$0")/../.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for package in zlib readline; do
    mkdir -p "$work/$package-1/debian"
    echo "$package (1:1.2-3) unstable; urgency=medium" >"$work/$package-1/debian/changelog"
    echo "Copyright 2026 the author of $package" >"$work/$package-1/debian/copyright"
done

script/third-party "$work/good" "$work/zlib-1"
[ "$(cat "$work/good/LICENSES.spdx")" = $'PackageName: zlib\nPackageVersion: 1:1.2-3\nPackageLicenseConcluded: Zlib' ]
! script/third-party "$work/bad" "$work/zlib-1" "$work/readline-1" 2>"$work/said"
[ "$(cat "$work/said")" = "error: the licence of readline is not in script/third-party" ]
[ ! -e "$work/bad/readline" ]

echo "<p>page</p>" >"$work/page"
tail -n +1 -- "$work"/good/* >"$work/THIRD-PARTY"
sh wasm/join "$work/page" "$work/page" "$work/THIRD-PARTY" >"$work/out"
grep -qx '<script type="text/plain" id="THIRD-PARTY">==> .*' "$work/out"
grep -qx "Copyright 2026 the author of zlib" "$work/out"
