#!/usr/bin/env bash
# The demo itself, short and with the binaries under test: what it promises must come out of it.
set -euo pipefail
source_dir=$1 bin=$2 work=$3
rm -rf "$work"
mkdir -p "$work"
export MIEN_DEMO_BIN=$bin MIEN_DEMO_OUT=$work/out MIEN_DEMO_CLIP=$work/clip MIEN_DEMO_SECONDS=1.5 MIEN_DEMO_TEXTURE=256 \
    MIEN_DEMO_TEXT="Hello, I am a face." CI=1
bash "$source_dir/scripts/demo"

fail() {
    echo "FAILED: $1"
    exit 1
}
for file in face.mien sheet.png side-by-side.mp4 table.txt; do
    [[ -s $work/out/$file ]] || fail "no $file"
done
holds() { jq -e "$2" "$work/out/$1.json" >/dev/null || fail "$1.json: not $2"; }
holds verify '.ok and .motion.rms_mm <= 0.1 and .motion.rms_mm > 0'
holds verify '.texture.psnr_y_db > 30 and .texture.ssim > 0.8 and .texture.frames == 45'
holds info '.frames == 45 and .complete and (.tracks | map(.kind)) == ["motion", "texture", "sound"]'
holds info '(.bytes | del(.total) | add) == .bytes.total'
# Every byte of the picture came over the socket, none from a cache.
holds play '.blobs.from_cache == 0 and .blobs.fetched >= 5 and .bytes.motion > 0 and .bytes.texture > 0'
holds play '.damaged_groups == 0 and .rendered_psnr_y_db > 30'
# The movie holds every frame and the sound.
movie=$(ffprobe -v error -count_frames -show_entries stream=codec_type,nb_read_frames -of csv=p=0 "$work/out/side-by-side.mp4")
grep -q '^video,45' <<<"$movie" || fail "the movie has not 45 frames: $movie"
grep -q '^audio' <<<"$movie" || fail "the movie has no sound"
echo "the demo holds its promises"
