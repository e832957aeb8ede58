#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "io/clip_check.hpp"
#include "io/clip_folder.hpp"
#include "io/file.hpp"
#include "io/scan_files.hpp"
#include "tests/temporary_folder.hpp"

namespace mien::io {
namespace {

using tests::TemporaryFolder;
constexpr int kMedium = 8, kFine = 16;

/// Maps with a number of its own in every texel, one of them not seen.
class CountingScans : public ScanSource {
public:
    std::int64_t frames() const override { return 3; }
    int medium_size() const override { return kMedium; }
    int fine_size() const override { return kFine; }
    bool has_albedo() const override { return true; }
    Result<Scan> read(std::int64_t frame, ScanParts) const override {
        Scan scan{map(kMedium, float(frame) + 0.125f), map(kFine, float(frame) + 0.3f), map(kFine, 0)};
        for (float& value : scan.albedo.values) value *= 1e-3f;
        scan.fine.at(3, 2)[0] = scan.fine.at(3, 2)[1] = scan.fine.at(3, 2)[2] = std::numeric_limits<float>::quiet_NaN();
        return scan;
    }

private:
    static FloatMap map(int size, float start) {
        FloatMap map(size, size, 3);
        for (std::size_t i = 0; i < map.values.size(); ++i) map.values[i] = start + 0.731f * float(i);
        return map;
    }
};

Clip scanned_clip() {
    Clip clip;
    clip.markers.emplace(3, 2);
    for (std::size_t i = 0; i < clip.markers->xyz.size(); ++i) clip.markers->xyz[i] = 70 * float(i % 6);
    clip.scans = std::make_shared<CountingScans>();
    clip.takes = {{"rest", 0}, {"smile", 1}};
    return clip;
}

TEST(ScanFiles, ComeBackAsTheyWere) {
    const TemporaryFolder folder;
    ASSERT_TRUE(write_clip(folder / "clip", scanned_clip()).ok());
    const auto loaded = load_clip(folder / "clip");
    ASSERT_TRUE(loaded.ok()) << loaded.error().message;
    const Clip& clip = loaded->clip;
    ASSERT_TRUE(clip.scans);
    EXPECT_EQ(clip.scans->frames(), 3);
    EXPECT_EQ(clip.scans->medium_size(), kMedium);
    EXPECT_EQ(clip.scans->fine_size(), kFine);
    ASSERT_EQ(clip.takes.size(), 2u);
    EXPECT_EQ(clip.takes[1].name, "smile");
    EXPECT_EQ(clip.takes[1].first, 1);
    for (std::int64_t f = 0; f < 3; ++f) {
        const Scan truth = *CountingScans().read(f, {});
        const auto scan = clip.scans->read(f);
        ASSERT_TRUE(scan.ok()) << scan.error().message;
        EXPECT_EQ(scan->medium.values, truth.medium.values);
        for (std::size_t i = 0; i < truth.fine.values.size(); ++i) {
            EXPECT_EQ(std::isnan(scan->fine.values[i]), std::isnan(truth.fine.values[i]));
            if (!std::isnan(truth.fine.values[i])) {
                EXPECT_EQ(scan->fine.values[i], truth.fine.values[i]);
            }
            EXPECT_NEAR(scan->albedo.values[i], truth.albedo.values[i], 5e-4f * std::abs(truth.albedo.values[i]) + 1e-7f);
        }
    }
}

TEST(ScanFiles, ScaleWithTheUnitOfTheClip) {
    const TemporaryFolder folder;
    Clip clip = scanned_clip();
    clip.unit = Unit::m;
    ASSERT_TRUE(write_clip(folder / "clip", clip).ok());
    const auto loaded = load_clip(folder / "clip");
    ASSERT_TRUE(loaded.ok()) << loaded.error().message;
    const auto scan = loaded->clip.scans->read(2);
    ASSERT_TRUE(scan.ok());
    const Scan truth = *CountingScans().read(2, {});
    for (std::size_t i = 0; i < truth.medium.values.size(); ++i) EXPECT_NEAR(scan->medium.values[i], truth.medium.values[i], 1e-4f);
}

TEST(ScanFiles, SayWhatIsWrong) {
    const TemporaryFolder folder;
    ASSERT_TRUE(write_clip(folder / "clip", scanned_clip()).ok());
    const std::filesystem::path medium = folder / "clip/positions_medium", fine = folder / "clip/positions_fine";
    std::filesystem::remove(fine / "000001.exr");
    std::filesystem::copy_file(medium / "000000.exr", folder / "clip/albedo/000000.exr", std::filesystem::copy_options::overwrite_existing);
    const std::string all = check_clip(folder / "clip").text();
    for (const char* said : {"number 1 is missing", "albedo/000000.exr is 8 x 8, but "}) EXPECT_NE(all.find(said), std::string::npos) << said << all;
    ASSERT_TRUE(write_clip(folder / "clip", scanned_clip(), {.overwrite = true}).ok());
    std::filesystem::remove(fine / "000002.exr");
    EXPECT_NE(load_clip(folder / "clip").error().message.find("2 frames"), std::string::npos);
    std::filesystem::copy_file(medium / "000002.exr", fine / "000002.exr");
    const auto loaded = load_clip(folder / "clip");
    ASSERT_TRUE(loaded.ok());
    EXPECT_NE(loaded->clip.scans->read(2).error().message.find("000002.exr"), std::string::npos) << "a map of another size";
    write_file(folder / "clip/clip.json", std::string_view(R"({"fps": 30, "unit": "mm", "markers": "markers.npy", "masks": "gone.png"})"));
    EXPECT_NE(load_clip(folder / "clip").error().message.find("there is no"), std::string::npos) << load_clip(folder / "clip").error().message;
    ASSERT_TRUE(write_clip(folder / "clip", scanned_clip(), {.overwrite = true}).ok());
    write_file(medium / "000000.exr", std::string_view("no picture"));
    EXPECT_NE(load_clip(folder / "clip").error().message.find("000000.exr"), std::string::npos);
    std::filesystem::remove_all(fine);
    EXPECT_FALSE(load_clip(folder / "clip").ok());
}

TEST(ScanFiles, DamagedPicturesAreRefusedOrRead) {
    const TemporaryFolder folder;
    ASSERT_TRUE(write_clip(folder / "clip", scanned_clip()).ok());
    const auto whole = read_bytes(folder / "clip/albedo/000000.exr");
    ASSERT_TRUE(whole.ok());
    const std::filesystem::path path = folder / "hurt.exr";
    for (std::size_t at = 0; at < whole->size(); at += 7) {
        Bytes hurt = *whole;
        hurt[at] = std::byte(std::to_integer<unsigned>(hurt[at]) ^ 0x5a);
        write_file(path, ByteView(hurt));
        if (const auto map = read_exr(path); map.ok()) {
            EXPECT_LE(map->width, 8192);
        }
        if (at >= 200) continue;
        write_file(path, ByteView(*whole).first(at));
        EXPECT_FALSE(read_exr(path).ok()) << "its header is cut at " << at;
    }
}

}  // namespace
}  // namespace mien::io
