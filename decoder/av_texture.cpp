#include "decoder/av_texture.hpp"

#include <optional>
#include <string>

#include "media/colour.hpp"
#include "media/picture.hpp"
#include "media/video_decoder.hpp"
#include "media/video_encoder.hpp"
#include "protocol/limits.hpp"
#include "protocol/texture_rungs.hpp"

namespace mien::decoder {

struct TextureDecoder::State {
    protocol::TextureInfo info;
    media::VideoDecoder video;
    bool in_group = false;
    std::int64_t first_frame = 0;
    std::int64_t fed = 0;    // objects of this group
    std::int64_t given = 0;  // pictures of this group

    Error fail(Error error) {
        in_group = false;
        error.message = "texture group at frame " + std::to_string(first_frame) + ": " + error.message;
        return error;
    }

    Result<std::vector<TextureFrame>> number(Result<std::vector<media::VideoPicture>> decoded) {
        if (!decoded) return fail(decoded.error());
        std::vector<TextureFrame> frames;
        for (media::VideoPicture& picture : *decoded) {
            if (given == fed) return fail({ErrorCode::damaged, "more pictures than objects"});
            YuvView view = picture.picture;
            const bool half = view.chroma_width < view.width;
            view.width = int(info.width);
            view.height = int(info.height);
            view.chroma_width = half ? (view.width + 1) / 2 : view.width;
            view.chroma_height = half ? (view.height + 1) / 2 : view.height;
            frames.push_back({first_frame + given++, view, std::move(picture.owner)});
        }
        return frames;
    }
};

TextureDecoder::TextureDecoder(std::unique_ptr<State> state) : state_(std::move(state)) {}
TextureDecoder::TextureDecoder(TextureDecoder&&) noexcept = default;
TextureDecoder& TextureDecoder::operator=(TextureDecoder&&) noexcept = default;
TextureDecoder::~TextureDecoder() = default;

Result<TextureDecoder> TextureDecoder::create(const protocol::Track& track, const protocol::Rung& rung,
                                              int threads) {
    const auto* of_track = std::get_if<protocol::TextureInfo>(&track.info);
    if (!of_track) return Error{ErrorCode::invalid, "track '" + track.name + "' is no texture track"};
    protocol::TextureInfo info = *of_track;
    const protocol::Rung::Size size = protocol::texture_size(track, rung);
    info.width = size.width;
    info.height = size.height;
    if (info.width == 0 || info.height == 0 || info.width > protocol::kMaxTextureSide ||
        info.height > protocol::kMaxTextureSide)
        return Error{ErrorCode::limit_exceeded, "texture of " + std::to_string(info.width) + " x " +
                                                    std::to_string(info.height) + " texels"};
    MIEN_TRY(video, media::VideoDecoder::open(
                        {rung.codec, rung.codec_config, media::coded_side(int(info.width)),
                         media::coded_side(int(info.height)), info.matrix, info.full_range, threads}));
    return TextureDecoder(std::unique_ptr<State>(new State{info, std::move(video)}));
}

void TextureDecoder::begin_group(std::int64_t first_frame) {
    state_->video.restart();
    state_->in_group = true;
    state_->first_frame = first_frame;
    state_->fed = state_->given = 0;
}

Result<std::vector<TextureFrame>> TextureDecoder::push(const protocol::Object& object) {
    if (!state_->in_group)
        return Error{ErrorCode::invalid, "texture object outside a group, or after an error in its group"};
    if (object.frames != 1)
        return state_->fail({ErrorCode::invalid, "a texture object holds exactly one frame"});
    ++state_->fed;
    return state_->number(state_->video.decode(object.bytes));
}

Result<std::vector<TextureFrame>> TextureDecoder::end_group(std::int64_t frames_of_group) {
    if (!state_->in_group)
        return Error{ErrorCode::invalid, "end of a texture group that has failed or not begun"};
    if (state_->fed < frames_of_group) {
        state_->in_group = false;
        return std::vector<TextureFrame>();
    }
    auto frames = state_->number(state_->video.drain());
    if (frames && state_->given != state_->fed)
        return state_->fail({ErrorCode::damaged, std::to_string(state_->fed) + " objects gave " +
                                                     std::to_string(state_->given) + " pictures"});
    state_->in_group = false;
    return frames;
}

Image to_rgb(const YuvView& picture) {
    return media::to_rgb(picture);
}

Result<Image> decode_picture(ByteView bytes) {
    return media::decode_picture(bytes);
}

}  // namespace mien::decoder
