#include "samples/performance_liveliness.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace mien::samples {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr float kTurn = float(2 * std::numbers::pi);
const Vec3 kNeck(0, -85, -25);  // head space, mm: the head turns about the top of the neck
constexpr float kViewDistance = 900;  // mm to what the eyes look at
constexpr float kHalfPupilDistance = 31.5f;

double ease(double x) {
    x = std::clamp(x, 0.0, 1.0);
    return x * x * (3 - 2 * x);
}
/// A pulse that rises over `rise` seconds to 1 at time 0 and falls over `fall`.
double pulse(double time, double rise, double fall) {
    return time < 0 ? ease(1 + time / rise) : ease(1 - time / fall);
}

std::size_t index(std::string_view name) { return std::size_t(arkit_index(name)); }

}  // namespace

Liveliness::Drift::Drift(Random& random, double low_hz, double high_hz) {
    for (std::size_t i = 0; i < frequency_.size(); ++i) {
        // One sinusoid in each part of the band, so that every seed has slow and quick parts.
        const double part = (double(i) + random.uniform()) / double(frequency_.size());
        frequency_[i] = 2 * std::numbers::pi * low_hz * std::pow(high_hz / low_hz, part);
        phase_[i] = random.uniform(0, kTurn);
    }
}

float Liveliness::Drift::operator()(double time) const {
    double sum = 0;
    for (std::size_t i = 0; i < frequency_.size(); ++i)
        sum += std::sin(frequency_[i] * time + phase_[i]) / (1 + 0.35 * double(i));
    return float(sum * 0.95);
}

Liveliness::Liveliness(double seconds, std::vector<Accent> accents, std::vector<Phrase> phrases, std::uint64_t seed)
    : seconds_(seconds), accents_(std::move(accents)), phrases_(std::move(phrases)) {
    Random random(seed);
    yaw_ = Drift(random, 0.07, 0.55);
    pitch_ = Drift(random, 0.08, 0.6);
    roll_ = Drift(random, 0.06, 0.4);
    sway_ = Drift(random, 0.05, 0.35);
    rise_ = Drift(random, 0.07, 0.4);
    smile_ = Drift(random, 0.05, 0.25);
    brow_ = Drift(random, 0.08, 0.5);
    squint_ = Drift(random, 0.06, 0.3);
    tremor_ = Drift(random, 1.1, 3.5);
    breath_phase_ = random.uniform(0, kTurn);
    for (std::size_t i = 0; i < uneven_.size(); ++i) uneven_[i] = float(1 + 0.07 * std::clamp(double(random.normal()), -1.5, 1.5));

    // Blinks: intervals are log-normal around three seconds; one often comes at the end of a phrase (Bentivoglio et al.
    // 1997: 26 a minute in conversation). Lids close in 70-100 ms, rest, and open in 120-180 ms.
    std::vector<double> wanted;
    for (double t = random.uniform(0.7f, 1.6f); t < seconds;) {
        wanted.push_back(t);
        t += std::clamp(std::exp(std::log(3.0) + 0.42 * random.normal()), 1.1, 7.0);
    }
    for (const Phrase& phrase : phrases_)
        if (random.uniform() < (phrase.ends_sentence ? 0.75 : 0.35)) wanted.push_back(phrase.end + random.uniform(-0.05f, 0.12f));
    std::sort(wanted.begin(), wanted.end());
    for (double start : wanted) {
        Blink blink{start, random.uniform(0.070f, 0.100f), random.uniform(0.045f, 0.060f), random.uniform(0.125f, 0.180f),
                    float(random.uniform(0.97f, 1.0f)), float(random.uniform(-0.004f, 0.006f))};
        const bool twice = random.uniform() < 0.06;
        if (!blinks_.empty() && start < blinks_.back().start + (twice ? 0.45 : 0.9)) continue;
        blinks_.push_back(blink);
        blink_times_.push_back(start);
    }

    // Glances: mostly small corrections around the viewer's eyes, now and then away, most often before a sentence.
    auto away_at = [&](double t) {
        return std::any_of(phrases_.begin(), phrases_.end(),
                           [t](const Phrase& p) { return t > p.start - 0.35 && t < p.start - 0.02; });
    };
    fixations_.push_back({-1, 0, 0});
    for (double t = random.uniform(0.5f, 1.0f); t < seconds;) {
        const bool away = random.uniform() < (away_at(t) ? 0.35 : 0.09);
        const double spread = away ? 6.0 : 1.1;
        fixations_.push_back({t, float(spread * kDegree * std::clamp(double(random.normal()), -1.6, 1.6)),
                              float((away ? 2.5 : 0.7) * kDegree * std::clamp(double(random.normal()), -1.6, 1.6))});
        t += away ? random.uniform(0.35f, 0.8f) : random.uniform(0.35f, 1.7f);
    }
}

float Liveliness::lid(const Blink& blink, double time) const {
    const double t = time - blink.start;
    if (t < blink.closing) return float(blink.depth * ease(t / blink.closing));
    // Opening is slower, and slowest at its end.
    const double u = std::clamp((t - blink.closing - blink.closed) / blink.opening, 0.0, 1.0);
    return float(blink.depth * (1 - ease(1 - (1 - u) * (1 - u))));
}

void Liveliness::add(double time, Instant& instant) const {
    add_head(time, instant);
    add_eyes(time, instant);
    add_face(time, instant);
    for (std::size_t i = 0; i < uneven_.size(); ++i)
        if (kArkitNames[i].ends_with("Left")) instant.weights[i] *= uneven_[i];
    for (float& w : instant.weights) w = std::clamp(w, 0.f, 1.f);
}

void Liveliness::add_head(double time, Instant& instant) const {
    double yaw = 2.2 * yaw_(time) + 0.10 * tremor_(time);
    double pitch = 1.1 * pitch_(time) + 0.10 * tremor_(time + 7);  // > 0: up
    double roll = 1.2 * roll_(time) + 0.06 * tremor_(time + 3);
    for (const Accent& accent : accents_) {
        const double t = time - accent.time;
        pitch -= 2.6 * accent.strength * pulse(t - 0.04, 0.16, 0.42);
        pitch += 0.8 * accent.strength * pulse(t + 0.17, 0.15, 0.15);  // a nod begins with a small lift
    }
    for (const Phrase& phrase : phrases_) {
        pitch += 1.0 * pulse(time - phrase.start, 0.30, 0.9);
        if (phrase.ends_sentence) pitch -= 1.3 * pulse(time - phrase.end, 0.25, 0.8);
    }
    const double breath = std::sin(2 * std::numbers::pi * 0.24 * time + breath_phase_);
    const Eigen::Quaternionf turn = Eigen::AngleAxisf(float(yaw * kDegree), Vec3::UnitY()) *
                                    Eigen::AngleAxisf(float(-pitch * kDegree), Vec3::UnitX()) *
                                    Eigen::AngleAxisf(float(roll * kDegree), Vec3::UnitZ());
    const Vec3 shift(1.6f * sway_(time), float(0.9 * rise_(time) + 0.6 * breath), float(0.9 * rise_(time + 11)));
    RigidPose lively = turned_on_neck(turn);
    lively.translation += shift;
    instant.head = {(lively.rotation * instant.head.rotation).normalized(), lively.apply(instant.head.translation)};
}

void Liveliness::add_eyes(double time, Instant& instant) const {
    std::size_t k = 0;
    while (k + 1 < fixations_.size() && fixations_[k + 1].start <= time) ++k;
    float yaw = fixations_[k].yaw, pitch = fixations_[k].pitch;
    if (k > 0) {
        const Fixation& from = fixations_[k - 1];
        const float distance = std::hypot(yaw - from.yaw, pitch - from.pitch);
        // The main sequence of saccades: about 2.2 ms a degree on top of 21 ms (Carpenter 1988).
        const double duration = 0.021 + 0.0022 * distance / kDegree;
        const float part = float(ease((time - fixations_[k].start) / duration));
        yaw = from.yaw + part * (yaw - from.yaw);
        pitch = from.pitch + part * (pitch - from.pitch);
    }
    const Vec3 direction(std::sin(yaw) * std::cos(pitch), std::sin(pitch), std::cos(yaw) * std::cos(pitch));
    const Vec3 target = instant.head.inverse().apply(kViewDistance * direction);  // turned back: the head moves, the gaze stays
    for (int side : {0, 1}) {
        const Vec3 ray = target - Vec3(side == 0 ? -kHalfPupilDistance : kHalfPupilDistance, 0, 90);
        instant.gaze.yaw[side] += std::atan2(ray.x(), ray.z());
        instant.gaze.pitch[side] += std::atan2(ray.y(), std::hypot(ray.x(), ray.z()));
    }
    float lids[2] = {0, 0};
    for (const Blink& blink : blinks_) {
        lids[0] = std::max(lids[0], lid(blink, time));
        lids[1] = std::max(lids[1], lid(blink, time - blink.lag));
    }
    for (int side : {0, 1}) instant.gaze.pitch[side] -= float(1.5 * kDegree) * lids[side];  // eyes dip behind closing lids
    look(instant.gaze, instant.weights);
    static const std::size_t left = index("EyeBlinkLeft"), right = index("EyeBlinkRight"), squint = index("EyeSquintLeft"),
                             squint_right = index("EyeSquintRight"), down = index("BrowDownLeft");
    auto& w = instant.weights;
    w[left] = std::max(w[left], lids[1]);
    w[right] = std::max(w[right], lids[0]);
    w[squint] += 0.03f + 0.02f * squint_(time) + 0.10f * lids[1];
    w[squint_right] += 0.03f + 0.02f * squint_(time) + 0.10f * lids[0];
    for (std::size_t side : {0, 1}) w[down + side] += 0.03f * lids[0];
}

void Liveliness::add_face(double time, Instant& instant) const {
    static const std::size_t smile = index("MouthSmileLeft"), cheek = index("CheekSquintLeft"), inner = index("BrowInnerUp"),
                             outer = index("BrowOuterUpLeft"), sneer = index("NoseSneerLeft"), dimple = index("MouthDimpleLeft"),
                             close = index("MouthClose"), jaw = index("JawOpen");
    auto& w = instant.weights;
    double brows = 0.04 + 0.03 * brow_(time);
    double smiles = 0.10 + 0.03 * smile_(time);
    for (const Accent& accent : accents_)
        if (accent.brows) brows += 0.38 * accent.strength * pulse(time - accent.time + 0.05, 0.22, 0.5);
    for (const Phrase& phrase : phrases_) {
        brows += 0.16 * pulse(time - phrase.start - 0.05, 0.25, 0.6);
        if (phrase.ends_sentence) smiles += 0.10 * pulse(time - phrase.end - 0.2, 0.35, 0.7);
    }
    if (!phrases_.empty()) smiles += 0.22 * ease((time - phrases_.back().end + 0.1) / 0.7);  // done: a warmer look
    const float breath = float(std::max(0.0, std::sin(2 * std::numbers::pi * 0.24 * time + breath_phase_)));
    w[inner] += float(std::max(0.0, brows));
    for (std::size_t side : {0, 1}) {
        w[outer + side] += float(std::max(0.0, 0.8 * brows));
        w[smile + side] += float(std::max(0.0, smiles));
        w[dimple + side] += 0.04f;
        w[cheek + side] += float(0.6 * std::max(0.0, smiles));
        w[sneer + side] += 0.02f * breath;
    }
    // Lips closed by MouthClose stay closed when clamping or asymmetry moved the jaw.
    w[close] = std::min(w[close], w[jaw]);
}

namespace {

constexpr float kPerRadian = 1.65f;  // as ARKit relates the EyeLook weights to its eye angles

struct LookIndices {
    std::size_t down[2] = {index("EyeLookDownRight"), index("EyeLookDownLeft")};
    std::size_t up[2] = {index("EyeLookUpRight"), index("EyeLookUpLeft")};
    std::size_t toward_left[2] = {index("EyeLookInRight"), index("EyeLookOutLeft")};
    std::size_t toward_right[2] = {index("EyeLookOutRight"), index("EyeLookInLeft")};
};
const LookIndices& look_indices() {
    static const LookIndices indices;
    return indices;
}

}  // namespace

void look(const Gaze& gaze, std::array<float, kArkitCount>& weights) {
    const LookIndices& at = look_indices();
    for (int side : {0, 1}) {
        weights[at.down[side]] = std::clamp(-kPerRadian * gaze.pitch[side], 0.f, 1.f);
        weights[at.up[side]] = std::clamp(kPerRadian * gaze.pitch[side], 0.f, 1.f);
        weights[at.toward_left[side]] = std::clamp(kPerRadian * gaze.yaw[side], 0.f, 1.f);
        weights[at.toward_right[side]] = std::clamp(-kPerRadian * gaze.yaw[side], 0.f, 1.f);
    }
}

Gaze gaze_of(const std::array<float, kArkitCount>& weights) {
    const LookIndices& at = look_indices();
    Gaze gaze;
    for (int side : {0, 1}) {
        gaze.pitch[side] = (weights[at.up[side]] - weights[at.down[side]]) / kPerRadian;
        gaze.yaw[side] = (weights[at.toward_left[side]] - weights[at.toward_right[side]]) / kPerRadian;
    }
    return gaze;
}

RigidPose turned_on_neck(const Eigen::Quaternionf& rotation) { return {rotation, kNeck - rotation * kNeck}; }

}  // namespace mien::samples
