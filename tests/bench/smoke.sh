#!/usr/bin/env bash
# mien-bench as a user meets it: a little of everything, a report that goes on where it was, clear errors.
set -uo pipefail
bench=$1/mien-bench work=$2
rm -rf "$work"
mkdir -p "$work"
cd "$work" || exit 2
failures=0

complain() {
    echo "FAILED: $1"
    failures=$((failures + 1))
}
# refuses CODE WORDS COMMAND...
refuses() {
    local want=$1 words=$2 said code
    shift 2
    said=$("$@" 2>&1)
    code=$?
    [[ $code == "$want" ]] || complain "exit $code, not $want, from: $* ($said)"
    grep -qiE "$words" <<<"$said" || complain "'$words' not in what it said: $* -> $said"
}

"$bench" --smoke --json r.json --csv r.csv --html r.html --markdown r.md >said.txt 2>&1 || complain "--smoke: $(tail -n 5 said.txt)"
for list in geometry timing texture clips; do
    [[ $(jq ".$list | length" r.json) -gt 0 ]] || complain "no $list in the report"
done
[[ $(jq '[.absent[] | select(.[0] == "drawn views")] | length' r.json) == 1 || $(jq '.views | length' r.json) -gt 0 ]] || complain "no views, and no word why"
[[ $(jq '[.geometry[], .texture[], .views[] | select(.failed != "")] | length' r.json) == 0 ]] || complain "rows failed: $(jq -c '[.geometry[], .texture[] | select(.failed != "")]' r.json)"
# Times of one set are of one run with ours in it.
jq -e '[.timing[] | select(.set == "frame")] | map(.run) | unique | length == 1' r.json >/dev/null || complain "a timing table is not of one run"
jq -e '[.timing[] | select(.set == "frame")][0].codec == "mien-live"' r.json >/dev/null || complain "the subject does not come first"
grep -q '^geometry,' r.csv || complain "no motion in the CSV"
grep -q '</html>' r.html || complain "the page has no end"
grep -q '^## ' r.md || complain "no Markdown"

# Finished rows stay: the second run changes nothing but the machine, the date and the command.
cp r.json before.json
"$bench" --smoke -q --json r.json >said.txt 2>&1 || complain "going on: $(tail -n 5 said.txt)"
rows='[.geometry, .timing, .texture, .views]'
[[ $(jq -S "$rows" before.json) == "$(jq -S "$rows" r.json)" ]] || complain "finished rows were run again"
"$bench" --json r.json --html again.html --markdown again.md --made "mien stage -o first" --made "mien stage -o second" >said.txt 2>&1 || complain "pages of a report that is there: $(cat said.txt)"
for page in again.html again.md; do
    tr '\n' ' ' <"$page" | grep -q "mien stage -o first mien stage -o second mien-bench --smoke" || complain "$page lacks the commands that made the clips"
done
grep -q '</html>' again.html || complain "no page of a report that is there"

refuses 2 "name a clip" "$bench"
refuses 2 "nosuchoption" "$bench" --nosuchoption
refuses 2 "rms" "$bench" --smoke --rms -1
refuses 1 "nowhere" "$bench" nowhere
refuses 2 "no codec .foo" "$bench" nowhere --codecs raw,foo
refuses 2 "no codec .vp9" "$bench" nowhere --texture-codecs vp9
refuses 1 "nowhere" "$bench" nowhere --motion-speed
refuses 2 "known" "$bench" nowhere --known 10
refuses 2 "a clip" "$bench" --json r.json --motion-speed
refuses 1 "markers" "$bench" --smoke --motion markers
refuses 1 "cannot write" "$bench" --smoke -q --no-texture --no-timing --codecs raw --csv /proc/nowhere/r.csv
echo '{"format": "of another program"}' >other.json
refuses 1 "other.json" "$bench" --smoke --json other.json
refuses 1 "missing.json" "$bench" --json missing.json
echo "a stream" >face.mien
refuses 1 "no earlier --html" "$bench" --json r.json --html face.mien
refuses 1 "no earlier --csv" "$bench" --smoke --csv face.mien
refuses 1 "what is read" "$bench" --json r.json --markdown r.json
refuses 2 "picture-row writes" "$bench" nowhere --picture-row face.mien
[[ $(cat face.mien) == "a stream" ]] || complain "a file of another kind was written over"
"$bench" --list | grep -q 'mien-live' || complain "--list does not list"

[[ $failures == 0 ]] && echo "mien-bench holds its promises"
exit $((failures > 0))
