#!/usr/bin/env bash
# Holds every #include against the table of docs/architecture.md: which room may use which.
set -u
cd "${1:-.}" || exit 2

declare -A may=(
    [core]=""
    [coding]="core" [model]="core" [protocol]="core" [media]="core"
    [io]="media core"
    [encoder]="model coding protocol media core"
    [decoder]="model coding protocol core"
    [net]="protocol core"
    [render]="model core"
    [analysis]="model io media core"
    [samples]="model io media core"
    [server]="net protocol core"
    [player]="decoder net render io model coding protocol media core"
)
failed=0
for room in "${!may[@]}"; do
    allowed=" $room ${may[$room]} "
    while IFS=: read -r file line include; do
        target=$(sed -E 's/.*#include "([a-z_]+)\/.*/\1/' <<<"$include")
        [[ -d $target ]] || continue
        # decoder_av is the decoder's only way to FFmpeg.
        [[ $room == decoder && $target == media && $(basename "$file") == av_* ]] && continue
        if [[ $allowed != *" $target "* ]]; then
            echo "$file:$line: $room must not use $target: $include"
            failed=1
        fi
    done < <(grep -nE '^#include "[a-z_]+/' -r "$room" --include='*.hpp' --include='*.cpp')
done
[[ $failed == 0 ]] && echo "every #include follows the arrows"
exit $failed
