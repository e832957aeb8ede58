#!/usr/bin/env bash
# A live performance, from packets to pictures: sender, mien live, server and players are programs of their own.
set -euo pipefail
bin=$1 work=$2
rm -rf "$work"
mkdir -p "$work/streams"
cd "$work"
jobs_of_ours=()
trap 'kill "${jobs_of_ours[@]}" 2>/dev/null || true' EXIT

fail() {
    echo "FAILED: $1"
    exit 1
}
says() { # what, file, text
    for _ in $(seq 200); do
        grep -q "$3" "$2" && return
        sleep 0.1
    done
    cat "$2"
    fail "$1 never said '$3'"
}

"$bin/mien" stage -q -o take --expressions --texture-size 0 --seconds 4 --fps 30
"$bin/mien" encode -q take -o training.mien --motion markers --preset live --no-texture --no-sound
[[ $("$bin/mien" encode -q take -o other.mien --basis training.mien --rms 0.2 2>&1) == "" ]] || fail "encode --basis"

"$bin/mien-serve" streams --port 0 >plain.log 2>&1 && fail "an empty folder without --publish is nothing to serve"
"$bin/mien-serve" streams --port 0 --publish >serve.log 2>&1 &
jobs_of_ours+=($!)
says mien-serve serve.log 'listening on mien://127.0.0.1:'
server=$(sed -n 's/^listening on \(mien:[^ ]*[0-9]\).*/\1/p' serve.log)
port=$((20000 + RANDOM % 20000))

"$bin/mien" live "$server/face" --basis training.mien --udp $port --sound-udp $((port + 1)) -o recorded.mien >live.log 2>&1 &
live=$!
jobs_of_ours+=($live)
says "mien live" live.log 'live on'
"$bin/mien-play" --list "$server" | grep -qx 'face  live' || fail "the stream is not listed as live"
"$bin/mien" live "$server/face" --basis training.mien --stdin </dev/null >second.log 2>&1 && fail "a second publisher of the name"
grep -q "somebody else publishes 'face'" second.log || fail "the second publisher is not told why"

"$bin/mien" stage -q -o talk --say "How do you do?" --texture-size 0 --fps 30
"$bin/mien" send take --udp $port --sound-udp $((port + 1)) >mute.log 2>&1 && fail "sound of a clip that has none"
grep -q 'the clip has no sound' mute.log || fail "no reason why there is no sound"
"$bin/mien" send talk --udp $port --sound-udp $((port + 1)) --loop >send.log 2>&1 &
sender=$!
jobs_of_ours+=($sender)
"$bin/mien-play" --headless "$server/face" -o live.png --size 160x180 --cache none
"$bin/mien-play" --headless "$server/face" -o live.mp4 --seconds 2 --size 160x180 --cache none --stats-json play.json
jq -e '.damaged_groups == 0 and .bytes.motion > 0 and .bytes.sound > 1000 and .frames > 0 and .frames + .dropped_frames > 20' play.json >/dev/null || fail "play.json: $(cat play.json)"
"$bin/mien-play" --headless "$server/face" --sheet no.png 2>refused.log && fail "a sheet of a live stream"
grep -q 'this stream is live' refused.log || fail "no reason why there is no sheet"

# The end: the movie of a viewer ends with the stream, the recording is whole.
"$bin/mien-play" --headless "$server/face" -o end.mp4 --seconds 600 --size 160x180 --cache none 2>end.log &
viewer=$!
sleep 2
kill $sender
kill -INT $live
wait $live || fail "mien live does not end cleanly: $(cat live.log)"
wait $viewer || fail "the viewer does not end with the stream: $(cat end.log)"
grep -q 'the live stream has ended' end.log || fail "the viewer does not say that the stream has ended"
grep -Eq '^[0-9]+ frames, .* 0 refused' live.log || fail "no summary: $(cat live.log)"
"$bin/mien" info --json recorded.mien | jq -e '.complete and .frames > 60 and .bytes.sound > 4000' >/dev/null || fail "the recording is not whole"
"$bin/mien" decode -q recorded.mien -o recorded || fail "the recording does not decode"
size() { stat -c %s "$1"; }
# 16 bits at 48 kHz, frames at 30 Hz: sound and pictures are as long as each other, within a third of a second.
frames=$("$bin/mien" info --json recorded.mien | jq .frames)
difference=$(((($(size recorded/sound.wav) - 44) / 96 - frames * 1000 / 30)))
((${difference#-} < 350)) || fail "the recording's sound is $difference ms longer than its picture"

# And from standard input, as fast as it comes: the clip's own markers as lines of numbers.
tail -c $((120 * 182 * 12)) take/markers.npy | od -An -v -tf4 -w$((182 * 12)) | sed 's/^ *//; s/  */,/g' |
    "$bin/mien" live --basis training.mien --stdin -o lines.mien -q
"$bin/mien" verify --json lines.mien take | jq -e '.ok and .motion.rms_mm < 0.2' >/dev/null || fail "lines: $("$bin/mien" verify lines.mien take)"
echo "live holds its promises"
