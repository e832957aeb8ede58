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
for again in -y --overwrite -f --force; do does "$mien" stage -o replaced --expressions --seconds 0.1 --texture-size 0 --markers 0 $again; done

# Every kind of motion keeps its promise, as re-measured by a process of its own.
does "$mien" encode clip -o vertices.mien --rms 0.1
does "$mien" verify vertices.mien clip --max-rms 0.1
does "$mien" encode clip -o peak.mien --peak 0.5 --no-texture
does "$mien" verify peak.mien clip --max-peak 0.5
does "$mien" encode clip -o rungs.mien --texture-rungs 30@32,90 --no-sound
for rung in 0 1; do
    "$mien" verify rungs.mien clip --texture-rung $rung --json >rung$rung.json || complain "verify of rung $rung fails"
    does "$mien" decode rungs.mien -o rung$rung --texture-rung $rung
done
jq -es '.[0].texture.psnr_y_db < .[1].texture.psnr_y_db' rung0.json rung1.json >/dev/null || complain "a finer rung of texture is no better"
jq -e '[.tracks[] | select(.kind == "texture") | .description] == ["32 x 32", "64 x 64"]' <("$mien" info rungs.mien --json) >/dev/null ||
    complain "info does not show the rungs of texture: $("$mien" info rungs.mien --json)"
refuses "lowest" "$mien" encode clip -o x.mien --texture-rungs 90,30
refuses "kbit/s@texels" "$mien" encode clip -o x.mien --texture-rungs 30@
refuses "excludes" "$mien" encode clip -o x.mien --texture-rungs 30 --texture-kbps 30
does "$mien" encode clip -o markers.mien --motion markers --rms 0.1 --no-texture
does "$mien" verify markers.mien clip --max-rms 0.1
does "$mien" encode clip -o weights.mien --motion weights --rms 0.005 --no-texture --preset live --group 0.2
does "$mien" verify weights.mien clip --max-rms 0.005
does "$mien" encode clip -o old.mien --preset guenter98 --rms 0.1 --no-texture --group whole
does "$mien" verify old.mien clip --max-rms 0.1
refuses "exceeds" "$mien" verify vertices.mien clip --max-rms 0.0001
does "$mien" stage -o other --expressions --seconds 0.5 --texture-size 0 --markers 40 --seed 2
refuses "of another face" "$mien" verify vertices.mien other
refuses "not compared: texture" "$mien" verify vertices.mien other
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

# One frame; a head of the wrong unit, named as such; an unknown key.
triangle() { # triangle FOLDER MM FRAMES: a clip of one large triangle that stands still
    mkdir -p "$1" && echo '{"fps": 30, "unit": "mm", "vertices": "v.npy", "neutral": "n.obj"}' >"$1/clip.json"
    printf 'v 0 0 0\nv %s 0 0\nv 0 %s 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n' "$2" "$2" >"$1/n.obj"
    for _ in $(seq "$3"); do head -c 12 /dev/zero; f32 "$2"; head -c 12 /dev/zero; f32 "$2"; head -c 4 /dev/zero; done | npy "$1/v.npy" "$3, 3, 3"
}
f32() { # the lengths that are used here, as little-endian float32
    case $1 in
        0.2) printf '\xcd\xcc\x4c\x3e' ;; 200) printf '\x00\x00\x48\x43' ;; 200000) printf '\x00\x50\x43\x48' ;;
    esac
}
says() { # says WORDS COMMAND...: succeeds, and says WORDS
    local words=$1
    shift
    "$@" >log.txt 2>&1 || complain "$* -> $(cat log.txt)"
    grep -qE "$words" log.txt || complain "'$words' not in what it said: $* -> $(cat log.txt)"
}
triangle one 200 1
does "$mien" encode one -o one-frame.mien
does "$mien" verify one-frame.mien one --max-rms 0.1
does "$mien" decode one-frame.mien -o one-back
triangle tiny 0.2 2
refuses "0\.2 mm.*unit should be m, not mm" "$mien" check tiny
says "0\.2 mm.*unit should be m, not mm" "$mien" encode tiny -o tiny.mien
triangle huge 200000 2
refuses "200 m " "$mien" check huge
says "200 m " "$mien" encode huge -o huge.mien
triangle odd 200 3
echo '{"fps": 30, "unit": "mm", "vertices": "v.npy", "neutral": "n.obj", "colour": "blue"}' >odd/clip.json
says "colour" "$mien" check odd
says "colour" "$mien" encode odd -o odd.mien
# Textures of odd sides and with alpha; sound that is longer or shorter than the picture.
triangle sounding 200 3
mkdir sounding/texture
ffmpeg -v error -f lavfi -i testsrc2=size=513x511:rate=30,format=rgba -frames:v 3 sounding/texture/%04d.png || complain "no ffmpeg here"
echo '{"fps": 30, "unit": "mm", "vertices": "v.npy", "neutral": "n.obj", "texture": "texture/%04d.png", "sound": "s.wav"}' >sounding/clip.json
for seconds in 1.5 0.02; do
    ffmpeg -v error -y -f lavfi -i sine=sample_rate=48000:duration=$seconds sounding/s.wav
    says "s\.wav is .* s (longer|shorter) than the picture|0:00\.1" "$mien" encode sounding -y -o sounding.mien
    says "PSNR-Y" "$mien" verify sounding.mien sounding
done
# A whole sound of another rate than Opus has ends up to a sample earlier or later: it lacks nothing.
for samples in 4416 4423; do
    ffmpeg -v error -y -f lavfi -i sine=sample_rate=44100:duration=1 -af "atrim=end_sample=$samples" sounding/s.wav
    does "$mien" encode sounding -y -o sounding.mien --no-texture
    "$mien" verify sounding.mien sounding --no-texture --json 2>log.txt | jq -e '.sound.missing_s == 0' >/dev/null || complain "a whole sound of $samples samples lacks something: $(cat log.txt)"
done
# A stream of half the sound is not all well.
ffmpeg -v error -y -f lavfi -i sine=sample_rate=48000:duration=0.05 sounding/s.wav
does "$mien" encode sounding -y -q -o sounding.mien
ffmpeg -v error -y -f lavfi -i sine=sample_rate=48000:duration=0.1 sounding/s.wav
refuses "lacks 0.050 s of the sound" "$mien" verify sounding.mien sounding
ffmpeg -v error -y -f lavfi -i sine=sample_rate=48000:duration=0.02 sounding/s.wav
does "$mien" encode sounding -y -q -o sounding.mien
does "$mien" decode sounding.mien -o sounding-back
does "$mien" check sounding-back
does "$bin/mien-play" --headless sounding.mien -o sounding.png --size 64x64
refuses "there already; -y" "$bin/mien-play" --headless sounding.mien -o sounding.png --size 64x64
does "$bin/mien-play" --headless sounding.mien -o sounding.png -y --size 64x64 --start 0:00.05 --rung 0
# What is read is never written over, and nothing is that is no older report.
cp sounding.mien before.mien
ln -s sounding.mien link.png
refuses "what is read" "$bin/mien-play" --headless sounding.mien -o link.png -y
refuses "what is read" "$bin/mien-play" --headless sounding.mien -o x.png --stats-json sounding.mien
refuses "what is read" "$bin/mien-play" --headless sounding.mien -o x.png --compare sounding --stats-json sounding/clip.json
refuses "sheet writes .png" "$bin/mien-play" --headless sounding.mien --sheet x.mien
refuses "no earlier" "$bin/mien-play" --headless sounding.mien -o x.png --stats-json vertices.mien
cmp -s sounding.mien before.mien || complain "the player has written over its input"
rm link.png
refuses "a time is" "$bin/mien-play" --headless sounding.mien -o x.png --start 1:75
refuses "for the window" "$bin/mien-play" --headless sounding.mien -o x.png --pause
refuses "for the window" "$bin/mien-play" --headless sounding.mien -o x.png --rung auto
refuses "file has its whole model" "$bin/mien-play" --headless sounding.mien -o x.png --model-kb 100
refuses "speed" "$bin/mien-play" sounding.mien --speed 40
for key in "p pause" "9 0 volume" "l loop" "{ }" "- + rung" "F1 help"; do
    "$bin/mien-play" --help | grep -qF -- "$key" || complain "mien-play --help does not list '$key'"
done

# Bad input.
refuses "already" "$mien" encode clip -o vertices.mien
refuses "no clip nowhere" "$mien" encode nowhere -o x.mien
refuses "nosuchcodec" "$mien" encode clip -o x.mien --texture-codec nosuchcodec
refuses "group" "$mien" encode clip -o x.mien --group never
refuses "excludes" "$mien" encode clip -o x.mien --rms 1 --motion-kbps 1
refuses "cannot|permission|no such" "$mien" encode clip -o /proc/nowhere/x.mien
refuses "cannot|no such" "$mien" info missing.mien
head -c 3000 vertices.mien >cut.mien
refuses "." "$mien" decode cut.mien -o cutclip
# Cut behind the face model, a stream gives what it still holds.
does "$mien" encode clip -o grouped.mien --group 0.1 --no-sound
size=$(stat -c %s grouped.mien)
for part in 95 98; do
    head -c $((size * part / 100)) grouped.mien >cut.mien
    refuses "error: .*(ends|cut|index).*: the stream has [0-9]+ frames but the clip has" "$mien" verify cut.mien clip --no-texture
    says "holds [1-9][0-9]* of its" "$mien" decode cut.mien -o "held-$part"
    does "$mien" check "held-$part"
done
# A byte wrong amid its groups: what is lost is named, everything else is written, and the exit code tells.
cp grouped.mien spoilt.mien
printf '\x5a\xa5' | dd of=spoilt.mien bs=1 seek=$((size * 97 / 100)) conv=notrunc 2>/dev/null
refuses "frames? [0-9]+ to [0-9]+ are lost and repeat" "$mien" decode spoilt.mien -o spoilt
does "$mien" check spoilt
says "damaged groups: 1 of" "$mien" info spoilt.mien
jq -e '.complete == false and ([.tracks[].damaged_groups] | add == 1)' <("$mien" info spoilt.mien --json 2>log.txt) >/dev/null || complain "info --json of a damaged stream: $(cat log.txt)"
refuses "damaged or missing from 0:00\.[0-9]+ to 0:00" "$bin/mien-play" --headless spoilt.mien -o spoilt.mp4 --size 64x64
[[ -s spoilt.mp4 ]] || complain "no movie of a damaged stream"
says "no rung 7 of texture" "$bin/mien-play" --headless vertices.mien -o rung.png --size 64x64 --rung 7
[[ $(head -c 200 spoilt/vertices.npy | grep -aoE "shape': \([0-9]+") == "$(head -c 200 clip/vertices.npy | grep -aoE "shape': \([0-9]+")" ]] || complain "decode of a damaged stream changes the number of frames"
echo "no stream at all" >text.mien
refuses "text.mien" "$mien" info text.mien
mkdir empty
refuses "." "$mien" encode empty -o x.mien
mkdir points && echo '{"fps": 30, "unit": "mm", "markers": "m.npy"}' >points/clip.json
head -c 480 /dev/zero | npy points/m.npy "4, 10, 3"
does "$mien" encode points -o still.mien
does "$mien" verify still.mien points --max-rms 0.1
mkdir cloud && cp clip/markers.npy cloud/m.npy && cp points/clip.json cloud/
does "$mien" encode cloud -o cloud.mien
does "$bin/mien-play" --headless cloud.mien -o cloud.png --size 64x64
mkdir bad && echo '{"fps": 30, "unit": "mm", "vertices": "v.npy", "neutral": "n.obj"}' >bad/clip.json
printf 'v 0 0 0\nv 100 0 0\nv 0 100 0\nf 1 2 3\n' >bad/n.obj
{ head -c 36 /dev/zero; head -c 32 /dev/zero; printf '\x00\x00\xc0\x7f'; } | npy bad/v.npy "2, 3, 3"
refuses "frame 1.*(vertex|point) 2|(vertex|point) 2.*frame 1" "$mien" encode bad -o x.mien
refuses "frame 1.*(vertex|point) 2|(vertex|point) 2.*frame 1" "$mien" check bad
{ head -c 24 /dev/zero; } | npy bad/v.npy "1, 2, 3"
refuses "2.*3|3.*2" "$mien" encode bad -o x.mien
{ head -c 36 /dev/zero; head -c 32 /dev/zero; printf '\x00\x00\x80\x7f'; } | npy bad/v.npy "2, 3, 3"
refuses "vertex 2 of frame 1 is infinite" "$mien" encode bad -o x.mien
rm bad/v.npy
refuses "v\.npy" "$mien" encode bad -o x.mien
refuses "v\.npy" "$mien" check bad
mkdir objs && cp bad/n.obj objs/f0001.obj && { cat bad/n.obj; echo 'v 50 50 0'; } >objs/f0002.obj
refuses "f0002\.obj.*4.*3" "$mien" encode objs -o x.mien --fps 30
refuses "nosuchsound" "$mien" encode sounding -o x.mien --sound-codec nosuchsound
ls -A | grep -F x.mien && complain "a failed encode left a file"

# Numbers, names and outputs that make no sense are told before anything else, in few words.
for wrong in "rms 0" "rms nan" "rms 1e-9" "peak -1" "motion-kbps abc" "texture-kbps 0" "sound-kbps 1e300" "group abc" "fps abc" "threads 0" "texture-codec vp9" "sound-codec mp3"; do
    read -r option value <<<"$wrong"
    said=$("$mien" encode clip -o x.mien "--$option" "$value" 2>&1)
    [[ $? == 2 && ${#said} -lt 150 ]] || complain "--$option $value: $said"
done
refuses "no rung 9" "$mien" decode vertices.mien -o x --rung 9
refuses "no stream or model" "$mien" encode clip -y -o clip/neutral.obj
"$mien" info vertices.mien --json 2>log.txt >/dev/full && complain "a full standard output goes unnoticed"
grep -q "standard output" log.txt || complain "of a full standard output it says: $(cat log.txt)"
refuses "from -10 to 10" "$mien" stage -o x --expressions --actor ict:nowhere --identity 1e10

# Of two that write one file, one succeeds, and it is its own that is there. A file of the neighbouring name is nobody's.
echo precious >both.mien.part
"$mien" encode clip -q -o both.mien --no-texture --no-sound 2>log.txt &
first=$!
"$mien" encode second -q -o both.mien --no-texture --no-sound 2>>log.txt && winner=second || winner=clip
wait $first && [[ $winner == second ]] && complain "two encodes to one file both succeed"
frames=$("$mien" info both.mien --json | jq .frames)
[[ $winner$frames == second9 || $winner$frames == clip15 ]] || complain "of two encodes $winner succeeds, but the file has $frames frames: $(cat log.txt)"
[[ $(cat both.mien.part) == precious ]] || complain "both.mien.part is overwritten"
# A signal ends it, and leaves nothing.
"$mien" encode clip -q -o stopped.mien --no-texture --rms 0.003 2>log.txt &
encoding=$!
for _ in $(seq 200); do compgen -G ".stopped.mien.part*" >files.txt && break; sleep 0.05; done
kill -TERM $encoding
wait $encoding
[[ $? == 143 ]] || complain "exit code of an encode that is told to end"
grep -q "stopped by a signal" log.txt || complain "an encode that is told to end says: $(cat log.txt)"
ls -A | grep -F stopped.mien && complain "an encode that is told to end left a file"

# Who asks for JSON gets JSON, also when it goes wrong.
json_error() { # json_error COMMAND...: exit 1 and {"error": ...}
    "$@" >json.txt 2>/dev/null
    [[ $? == 1 ]] || complain "exit code of: $*"
    jq -e '.error | length > 0' json.txt >/dev/null || complain "no JSON error from: $* -> $(cat json.txt)"
}
json_error "$mien" info missing.mien --json
json_error "$mien" verify vertices.mien nowhere --json
"$mien" check nowhere --json >json.txt 2>/dev/null && complain "check of nothing succeeds"
jq -e . json.txt >/dev/null || complain "check --json of nothing: $(cat json.txt)"
"$mien" verify vertices.mien clip --max-rms 0.0001 --json 2>/dev/null >json.txt && complain "verify above its bound succeeds"
jq -e '.ok == false' json.txt >/dev/null || complain "verify --json above its bound: $(cat json.txt)"
# The command line misused is 2, from every program.
refuses "no command 'nosuchcommand'.*encode" "$mien" nosuchcommand
refuses "from 0.01 to 1000" "$mien" encode clip -o x.mien --fps 1000000000
for misused in "mien" "mien nosuchcommand" "mien encode clip" "mien-serve" "mien-serve . --port x" "mien-play --size 3" "mien-play --headless vertices.mien"; do
    $bin/$misused >/dev/null 2>&1
    [[ $? == 2 ]] || complain "exit code of: $misused"
done

# A full disk: a filesystem of 32 kB, where one can be had; then the same one without write permission.
mkdir full
if mount -t tmpfs -o size=32k tmpfs full 2>/dev/null; then
    head -c 24k /dev/zero >full/ballast
    left() { [[ $(ls -A full) == ballast ]] || complain "$1 on a full disk left $(ls -A full)"; rm -rf full/[!b]*; }
    refuses "space" "$mien" encode clip -o full/x.mien
    left encode
    refuses "space" "$mien" decode vertices.mien -o full/x
    refuses "space" "$mien" stage -o full/y --expressions --seconds 0.2 --texture-size 0 --markers 0
    rm -rf full/[!b]*
    refuses "space" "$bin/mien-play" --headless vertices.mien -o full/x.png --size 320x320
    left "a picture"
    refuses "space" "$bin/mien-play" --headless vertices.mien -o full/x.mp4 --size 320x320
    left "a movie"
    mount -o remount,ro full
    refuses "cannot write full/x.mien: read-only" "$mien" encode clip -o full/x.mien
    refuses "full.*read-only" "$mien" decode vertices.mien -o full/x
    refuses "full.*read-only" "$mien" stage -o full/y --expressions --seconds 0.2 --texture-size 0 --markers 0
    refuses "full.*read-only" "$bin/mien-play" --headless vertices.mien -o full/x.png --size 64x64
    umount full
else
    echo "full and read-only disk: skipped (no permission to mount)"
fi

# A model is learnt from scans, drives a stream by markers alone, and is refused where it does not fit.
does "$mien" stage -o session --session training --take-frames 4 --range-frames 6 --scans --scan-size 64 --texture-size 64 --markers 60
does "$mien" check session
does "$mien" train session -o actor.model --report report --order linear
jq -e '.clips[0].medium.linear.mean < .clips[0].medium.neutral.mean' report/report.json >/dev/null || complain "a model explains less than a still face does"
does "$mien" info actor.model
"$mien" info actor.model --json | jq -e '(.layers | map(.bytes) | add) == .bytes.total and (.layers | map(.name) | contains(["shape", "medium", "fine", "framing"])) and (has("fps") | not)' >/dev/null ||
    complain "info of a model: $("$mien" info actor.model --json)"
says "medium .*coding added" "$mien" train session -o small.model --order linear --kbytes $(($(stat -c %s actor.model) * 9 / 10000))
[[ $(stat -c %s small.model) -le $(($(stat -c %s actor.model) * 9 / 10000 * 1000)) ]] || complain "train --kbytes writes more than asked"
refuses "in 1000 bytes: .*it takes [0-9]+" "$mien" train session -o tiny.model --kbytes 1
does "$mien" train session -o coarse.model --coding-error 0.02,0.002,0.0006
does "$mien" train session -o fine.model --coding-error 0.02,0.0002,0.0006
[[ $(stat -c %s fine.model) -gt $(stat -c %s coarse.model) ]] || complain "a tenth of the coding error takes no more bytes"
refuses "coding-error" "$mien" train session -o other.model --coding-error 0.02
refuses "is there already" "$mien" train session -o actor.model
refuses "scans" "$mien" train clip -o other.model
refuses "cannot write" "$mien" train session -o nowhere/other.model
does "$mien" stage -o talk --expressions --seconds 0.4 --texture-size 0 --markers 60
does "$mien" encode talk -o driven.mien --model actor.model --rms 0.1
does "$mien" verify driven.mien talk --max-rms 0.1
[[ $("$mien" info driven.mien --json | jq -r .model) == $("$mien" info actor.model --json | jq -r .model) ]] || complain "a driven stream has another model than the file"
does "$bin/mien-play" --headless driven.mien -o driven.png --size 160x160
mkdir faceless && echo '{"weights": "w.npy", "fps": 30}' >faceless/clip.json && cp talk/weights.npy faceless/w.npy
does "$mien" encode faceless -o faceless.mien
refuses "without a face" "$bin/mien-play" --headless faceless.mien -o faceless.png
does "$mien" encode talk -o unmoved.mien --motion weights
grep -q "no target shapes" log.txt || complain "weights that move nothing are not warned of"
refuses "60 markers, but the clip has 40" "$mien" encode clip -o bad.mien --model actor.model
refuses "is a stream" "$mien" encode talk -o bad.mien --model driven.mien
does "$mien" evaluate actor.model session --every 3 --json
# Other markers of the same actor.
does "$mien" stage -o sparse --expressions --seconds 0.4 --texture-size 0 --markers 40 --scans --scan-size 64
refuses "40 markers|the clip has 40" "$mien" encode sparse -o bad.mien --model actor.model
refuses "mien remap" "$mien" evaluate actor.model sparse
does "$mien" remap actor.model sparse -o sparse.model
refuses "is there already" "$mien" remap actor.model sparse -o sparse.model
refuses "is a stream" "$mien" remap driven.mien sparse -o bad.model
does "$mien" encode sparse -o sparse.mien --model sparse.model --rms 0.1
does "$mien" verify sparse.mien sparse --max-rms 0.1
does "$mien" evaluate sparse.model sparse
does "$bin/mien-play" --headless sparse.mien -o sparse.png --size 160x160

# The server.
refuses "no such|not found|not a (folder|directory)|does not exist" "$bin/mien-serve" nowhere
"$bin/mien-serve" . --port 0 >serve.log 2>&1 &
server=$!
for _ in $(seq 100); do grep -q 'listening on' serve.log && break; sleep 0.1; done
port=$(sed -n 's/.*listening on mien:\/\/[^:]*:\([0-9]*\).*/\1/p' serve.log)
refuses "port $port.*in use" "$bin/mien-serve" . --port "$port"
# Without a window the whole model is drawn as from a file; a part of it when that was asked for.
driven=mien://127.0.0.1:$port/driven
does "$bin/mien-play" --headless "$driven" -o whole.png --size 160x160 --cache none --stats-json whole.json
does "$bin/mien-play" --headless "$driven" -o part.png --size 160x160 --cache none --stats-json part.json --model-kb 0
cmp -s driven.png whole.png || complain "the whole model from a server draws another picture than from a file"
cmp -s part.png whole.png && complain "a part of the model draws the picture of the whole one"
jq -es '.[0].model.bytes == .[0].model.of and .[1].model.bytes < .[1].model.of and .[1].startup_bytes < .[0].startup_bytes' whole.json part.json >/dev/null ||
    complain "figures of a part of the model: $(cat part.json)"
kill -TERM $server
wait $server || complain "the server did not stop cleanly: $(cat serve.log)"

[[ $failures == 0 ]] && echo "the command line holds its promises"
exit $((failures > 0))
