#include "io/clip_reader.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "io/image_file.hpp"
#include "io/numbered_files.hpp"
#include "io/scan_files.hpp"
#include "io/sound_file.hpp"
#include "io/texture_file.hpp"

namespace mien::io {
namespace {

namespace fs = std::filesystem;

}  // namespace

void ClipReader::read_texture() {
    if (description_.texture || !description_.texture_files.empty()) {
        sources_.texture = description_.texture ? description_.texture->string() : description_.texture_files[0].string();
        auto opened = take(description_.texture ? open_texture(*description_.texture) : open_pictures(description_.texture_files));
        if (opened) {
            if (opened->fault) findings_.problem(*opened->fault);
            for (std::string& note : opened->notes) findings_.note(std::move(note));
            clip_.texture = std::move(opened->source);
        }
    }
    if (scan_masks()) return;
    for (const fs::path& path : description_.masks) {
        auto mask = take(read_image(path, 1));
        if (!mask) continue;
        if (!clip_.mask) {
            clip_.mask = std::move(*mask);
        } else if (clip_.mask->width != mask->width || clip_.mask->height != mask->height) {
            problem(ErrorCode::mismatch, fmt::format("{} is {} x {}, but the first mask is {} x {}", path.string(), mask->width, mask->height,
                                                     clip_.mask->width, clip_.mask->height));
        } else {
            for (std::size_t i = 0; i < mask->pixels.size(); ++i) clip_.mask->pixels[i] = std::max(clip_.mask->pixels[i], mask->pixels[i]);
        }
    }
}

std::optional<fs::path> ClipReader::scan_masks() const {
    if (description_.masks.size() != 1 || !names_many(description_.masks[0])) return std::nullopt;
    return description_.masks[0];
}

void ClipReader::read_scans() {
    clip_.takes = description_.takes;
    if (unread("positions_medium") || unread("positions_fine")) return;
    const bool medium = description_.positions_medium.has_value(), fine = description_.positions_fine.has_value();
    if (!medium && !fine) {
        if (description_.albedo) findings_.warn("\"albedo\" is not used: there are no positions_medium and positions_fine");
        if (scan_masks()) problem(ErrorCode::mismatch, fmt::format("{} are masks of scans, but there are no positions_medium and positions_fine", description_.masks[0].string()));
        return;
    }
    if (!medium || !fine) return problem(ErrorCode::missing, fmt::format("scans need both positions_medium and positions_fine, but there is no {}", medium ? "positions_fine" : "positions_medium"));
    OpenedScans opened = open_scans({*description_.positions_medium, *description_.positions_fine, description_.albedo, scan_masks()}, millimetres(clip_.unit));
    for (Error& fault : opened.faults) findings_.problem(std::move(fault));
    clip_.scans = std::move(opened.source);
}

void ClipReader::read_sound_file() {
    if (!description_.sound) return;
    sources_.sound = description_.sound->string();
    auto sound = take(read_sound(*description_.sound));
    if (sound) clip_.sound = std::move(*sound);
}

}  // namespace mien::io
