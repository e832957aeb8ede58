#!/usr/bin/env bash
# The command line as a user meets it: round trips, promises kept, and bad input answered with a clear error.
set -uo pipefail
bin=$1 work=$2
rm -rf "$work"
mkdir -p "$work"
cd "$work" || exit 2
mien=$bin/mien
failures=0

complain() {
    echo "FAILED: $1"
    failures=$((failures + 1))
}
# refuses WORDS COMMAND...: fails with code 1 or 2, and says WORDS.
refuses() {
    local words=$1 said code
    shift
    said=$("$@" 2>&1)
    code=$?
    [[ $code == 1 || $code == 2 ]] || complain "exit $code from: $* ($said)"
    grep -qiE "$words" <<<"$said" || complain "'$words' not in what it said: $* -> $said"
}
does() { "$@" >log.txt 2>&1 || complain "$* -> $(cat log.txt)"; }
npy() { # npy FILE SHAPE: header of a float32 array, the values come on standard input
    local header="{'descr': '<f4', 'fortran_order': False, 'shape': ($2), }"
    local pad=$((64 - (11 + ${#header}) % 64))
    { printf '\x93NUMPY\x01\x00'; printf "\\x$(printf %02x $(((${#header} + pad + 1) % 256)))\\x$(printf %02x $(((${#header} + pad + 1) / 256)))"
      printf '%s%*s\n' "$header" "$pad" ""; cat; } >"$1"
}

does "$mien" stage -o clip --expressions --seconds 0.5 --texture-size 64 --markers 40
does "$mien" check clip
refuses "is there already|not empty|something in it" "$mien" stage -o clip --expressions --seconds 0.5 --texture-size 0

# Every kind of motion keeps its promise, as re-measured by a process of its own.
does "$mien" encode clip -o vertices.mien --rms 0.1
does "$mien" verify vertices.mien clip --max-rms 0.1
does "$mien" encode clip -o peak.mien --peak 0.5 --no-texture
does "$mien" verify peak.mien clip --max-peak 0.5
does "$mien" encode clip -o markers.mien --motion markers --rms 0.1 --no-texture
does "$mien" verify markers.mien clip --max-rms 0.1
does "$mien" encode clip -o weights.mien --motion weights --rms 0.005 --no-texture --preset live --group 0.2
does "$mien" verify weights.mien clip --max-rms 0.005
does "$mien" encode clip -o old.mien --preset guenter98 --rms 0.1 --no-texture --group whole
does "$mien" verify old.mien clip --max-rms 0.1
refuses "exceeds" "$mien" verify vertices.mien clip --max-rms 0.0001
does "$mien" decode vertices.mien -o back
does "$mien" check back
does "$mien" encode back -o again.mien
does "$mien" info vertices.mien

# A second clip of one actor shares the model's blobs.
does "$mien" stage -o second --expressions --seconds 0.3 --texture-size 64 --markers 40
does "$mien" encode second -o second.mien
[[ $("$mien" info vertices.mien --json | jq -r .model) == $("$mien" info second.mien --json | jq -r .model) ]] || complain "two clips of one actor have different models"
# The same output for any number of threads.
does "$mien" encode clip -o one.mien --threads 1 --name x
does "$mien" encode clip -o three.mien --threads 3 --name x
cmp -s one.mien three.mien || complain "the number of threads changes the stream"

# Bad input.
refuses "already" "$mien" encode clip -o vertices.mien
refuses "no clip nowhere" "$mien" encode nowhere -o x.mien
refuses "nosuchcodec" "$mien" encode clip -o x.mien --texture-codec nosuchcodec
refuses "group" "$mien" encode clip -o x.mien --group never
refuses "excludes" "$mien" encode clip -o x.mien --rms 1 --peak 1
refuses "cannot|permission|no such" "$mien" encode clip -o /proc/nowhere/x.mien
refuses "cannot|no such" "$mien" info missing.mien
head -c 3000 vertices.mien >cut.mien
refuses "." "$mien" decode cut.mien -o cutclip
echo "no stream at all" >text.mien
refuses "text.mien" "$mien" info text.mien
mkdir empty
refuses "." "$mien" encode empty -o x.mien
mkdir points && echo '{"fps": 30, "unit": "mm", "markers": "m.npy"}' >points/clip.json
head -c 480 /dev/zero | npy points/m.npy "4, 10, 3"
does "$mien" encode points -o still.mien
does "$mien" verify still.mien points --max-rms 0.1
mkdir bad && echo '{"fps": 30, "unit": "mm", "vertices": "v.npy", "neutral": "n.obj"}' >bad/clip.json
printf 'v 0 0 0\nv 100 0 0\nv 0 100 0\nf 1 2 3\n' >bad/n.obj
{ head -c 36 /dev/zero; head -c 32 /dev/zero; printf '\x00\x00\xc0\x7f'; } | npy bad/v.npy "2, 3, 3"
refuses "frame 1.*(vertex|point) 2|(vertex|point) 2.*frame 1" "$mien" encode bad -o x.mien
refuses "frame 1.*(vertex|point) 2|(vertex|point) 2.*frame 1" "$mien" check bad
{ head -c 24 /dev/zero; } | npy bad/v.npy "1, 2, 3"
refuses "2.*3|3.*2" "$mien" encode bad -o x.mien
[[ -e x.mien || -e x.mien.part ]] && complain "a failed encode left a file"

# A full disk: a filesystem of 16 kB, where one can be had.
mkdir full
if mount -t tmpfs -o size=16k tmpfs full 2>/dev/null; then
    refuses "space" "$mien" encode clip -o full/x.mien
    [[ -z $(ls -A full) ]] || complain "a full disk was left with $(ls -A full)"
    umount full
else
    echo "full disk: skipped (no permission to mount)"
fi

# The server.
refuses "no such|not found|not a (folder|directory)|does not exist" "$bin/mien-serve" nowhere
"$bin/mien-serve" . --port 0 >serve.log 2>&1 &
server=$!
for _ in $(seq 100); do grep -q 'listening on' serve.log && break; sleep 0.1; done
port=$(sed -n 's/.*listening on mien:\/\/[^:]*:\([0-9]*\).*/\1/p' serve.log)
refuses "use" "$bin/mien-serve" . --port "$port"
kill -TERM $server
wait $server || complain "the server did not stop cleanly: $(cat serve.log)"

[[ $failures == 0 ]] && echo "the command line holds its promises"
exit $((failures > 0))
