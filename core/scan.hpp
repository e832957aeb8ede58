#pragma once

#include <cstdint>
#include <string>

#include "core/image.hpp"
#include "core/result.hpp"

namespace mien {

/// What a scanner saw of one frame, as pictures in texture space: where each texel of the skin is, in head space (head pose
/// removed), mm, and what colour it has. NaN: not seen.
struct Scan {
    FloatMap medium;  ///< 3 channels: the smooth surface
    FloatMap fine;    ///< 3 channels: the surface with wrinkles and pores; has a size of its own
    FloatMap albedo;  ///< 3 channels, linear; of the fine map's size, or empty
};

/// Which maps of a scan are wanted: others may be left empty.
struct ScanParts {
    bool medium = true, fine = true, albedo = true;
};

/// Scans of a performance, read one at a time: a second of full maps is near a gigabyte.
class ScanSource {
public:
    virtual ~ScanSource() = default;
    virtual std::int64_t frames() const = 0;
    virtual int medium_size() const = 0;  ///< texels per side
    virtual int fine_size() const = 0;    ///< texels per side
    virtual bool has_albedo() const = 0;
    /// May be called from several threads at once.
    virtual Result<Scan> read(std::int64_t frame, ScanParts parts = {}) const = 0;
};

/// A run of frames that belong together, up to the next one's first: one expression of a training session.
struct Take {
    std::string name;
    std::int64_t first = 0;
};

}  // namespace mien
