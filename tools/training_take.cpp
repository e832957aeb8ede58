#include "tools/training_take.hpp"

#include "coding/motion_values.hpp"
#include "tools/model_file.hpp"

namespace mien::tools {

namespace {

constexpr std::int64_t kUsualGroup = 30;   // frames, where the take is one group

Result<encoder::TrainingTake> decode_take(const StoredStream& stream, const model::FaceModel& face) {
    const protocol::Track* track = stream.track(protocol::TrackKind::motion);
    if (!track) return Error{ErrorCode::missing, "it has no motion"};
    encoder::TrainingTake take;
    take.info = std::get<protocol::MotionInfo>(track->info);
    if (take.info.kind == protocol::MotionKind::vertices)
        return Error{ErrorCode::mismatch, "its motion is that of vertices; encode the training take with --motion markers or weights"};
    MIEN_TRY(decoder, stream.motion_decoder(face, 0));
    MIEN_TRY(basis, coding::read_motion_basis(take.shape(), *stream.blob(*track->rungs.front().basis), face.neutral.triangles, face.neutral.mirror));
    if (basis.scheme == coding::MotionScheme::guenter98) return Error{ErrorCode::mismatch, "it is of the scheme of 1998; encode the training take with --preset live"};
    std::vector<Eigen::VectorXd> columns;
    const int sides = take.shape().side_channels();
    MIEN_CHECK(stream.visit_motion(decoder, [&](const model::Motion& motion) -> Result<void> {
        Eigen::VectorXd& column = columns.emplace_back(sides + motion.coefficients.size());
        int row = 0;
        if (take.info.has_pose)
            for (const double v : coding::pose_steps(basis, motion.pose)) column[row++] = v;
        if (take.info.has_gaze)
            for (const double v : coding::gaze_steps(basis, motion.gaze)) column[row++] = v;
        for (int c = 0; c < row; ++c) column[c] -= basis.side_mean[std::size_t(c)];
        column.tail(motion.coefficients.size()) = motion.coefficients.cast<double>() / coding::MotionBasis::kFraction;
        return {};
    }));
    if (columns.empty()) return Error{ErrorCode::missing, "it has no frame"};
    take.samples.resize(columns.front().size(), Eigen::Index(columns.size()));
    for (std::size_t f = 0; f < columns.size(); ++f) take.samples.col(Eigen::Index(f)) = columns[f];
    take.basis = std::move(basis);
    take.group_frames = stream.header().group_frames ? stream.header().group_frames : kUsualGroup;
    return take;
}

}  // namespace

Result<void> same_reference(const StoredTake& take, const model::FaceModel& model, const std::string& path) {
    constexpr float kSame = 1e-3f;   // mm
    const Points* markers = model::driving_markers(model);
    if (take.take.info.kind != protocol::MotionKind::markers || !markers || markers->rows() != take.reference.rows() ||
        (*markers - take.reference).cwiseAbs().maxCoeff() > kSame)
        return Error{ErrorCode::mismatch, "the model '" + path + "' has other markers than the training take; encode the training take with --model too"};
    return {};
}

Result<StoredTake> read_take(const std::string& path) {
    MIEN_TRY(stream, StoredStream::open(path));
    const auto of_file = [&](const Error& error) { return Error{error.code, "'" + path + "' is no training take: " + error.message}; };
    StoredTake out;
    out.header = stream.header();
    auto model = model_of(stream);
    if (!model) return of_file(model.error());
    out.model = std::move(*model);
    auto take = decode_take(stream, out.model.model);
    if (!take) return of_file(take.error());
    out.take = std::move(*take);
    if (out.take.info.kind == protocol::MotionKind::markers) {
        const Points* markers = model::driving_markers(out.model.model);
        out.reference = markers ? *markers : out.model.model.neutral.positions;
        encoder::add_pose(out.take, out.reference);
    }
    return out;
}

}  // namespace mien::tools
