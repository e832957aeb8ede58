#include "player/refiner.hpp"

#include "driven_stream.hpp"
#include "player/face_view.hpp"
#include "player/session.hpp"
#include "render/detail_map.hpp"
#include "tests/render/gl_test.hpp"

/// A face model that gets better while its stream plays.
namespace mien::player {
namespace {

using namespace net::harness;

class RefinerGLTest : public render::GLTest {
protected:
    static SessionOptions options() {
        SessionOptions options;
        options.wait = 20;
        options.source.start_bytes = 0;
        options.source.first_backoff = 10ms;
        options.source.last_backoff = 50ms;
        return options;
    }
    static Session open(const std::string& input, SessionOptions options = RefinerGLTest::options()) {
        auto session = open_session(input, std::move(options));
        if (!session.ok()) throw std::runtime_error(session.error().message);
        session->decode->start();
        return std::move(*session);
    }
    static Image picture(FaceView& face) {
        render::Target target(160, 160, render::Smoothing::none);
        face.draw(face.framing(1, render::View::front).camera(), {}, target);
        return target.read();
    }
    /// The first frame as the whole model draws it.
    static Image truth(const Served& served) {
        const Session session = open((served.folder.path() / "take.mien").string());
        EXPECT_EQ(session.refiner, nullptr) << "a file has its whole model";
        FaceView face(*session.stream);
        const auto frame = session.decode->wait_pop({});
        EXPECT_TRUE(frame);
        if (frame) face.show(*frame);
        return picture(face);
    }
    /// What the window does between two pictures.
    static void refine(const Session& session, FaceView& face) {
        if (face.refining()) return;
        if (auto pictures = session.refiner->take()) face.refine(std::move(pictures));
    }
};

double squared_difference(const Image& a, const Image& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i) sum += std::pow(double(a.pixels[i]) - double(b.pixels[i]), 2);
    return sum;
}

TEST_F(RefinerGLTest, PlayingBeginsBeforeTheLastRefinementAndEndsWithTheWholeModelsPicture) {
    const Served served(driven_stream());
    const Image whole = truth(served);
    Proxy proxy(served.server->port());
    const std::string url = "mien://127.0.0.1:" + std::to_string(proxy.port()) + "/take";
    // What a viewer without refinements takes; no refinement is small enough to come whole in place of a group.
    SessionOptions unrefined = options();
    unrefined.source.refine = false;
    for (const Session session = open(url, unrefined); session.decode->wait_pop({});) {}
    const std::uint64_t needed = proxy.served();
    // What is held is not there before it is let through, however slow this machine is: at first every refinement, then about half.
    proxy.hold_after(2 * needed);
    const Session session = open(url);
    ASSERT_NE(session.refiner, nullptr);
    const auto frame = session.decode->wait_pop({});
    ASSERT_TRUE(frame);
    FaceView face(*session.stream);
    face.show(*frame);
    const Image first = picture(face);
    const auto have = [&] { return session.source->statistics().model_bytes; };
    const std::uint64_t all = session.source->statistics().model_size;
    EXPECT_LT(have(), all) << "the first picture came before the last refinement";
    EXPECT_NE(first.pixels, whole.pixels);

    // One frame held, as in a pause, while the model comes.
    proxy.hold_after(2 * needed + 5000);
    Image better = first;
    EXPECT_TRUE(wait_until([&] { return refine(session, face), better = picture(face), better.pixels != first.pixels; }));
    EXPECT_NE(better.pixels, whole.pixels) << "it gets better blob by blob";
    EXPECT_LT(squared_difference(better, whole), squared_difference(first, whole));
    EXPECT_LT(have(), all);
    proxy.hold_after(0);
    EXPECT_TRUE(wait_until([&] {
        refine(session, face);
        const Image now = picture(face);
        EXPECT_LT(squared_difference(now, whole), squared_difference(first, whole)) << "nothing but better pictures of this face is ever drawn";
        return now.pixels == whole.pixels && have() == all;
    }));
    EXPECT_EQ(session.unrefined(), "");
    EXPECT_EQ(session.source->statistics().blobs_fetched, served.stream.blobs.size());
}

TEST_F(RefinerGLTest, ACutInMidRefinementLeavesNothingOut) {
    const Served served(driven_stream());
    const Image whole = truth(served);
    Proxy proxy(served.server->port());
    proxy.throttle(20000);
    proxy.cut_after(needed_bytes(served.stream) + 3000);
    SessionOptions wanted = options();
    wanted.source.on_status = [&](const net::SourceStatus& status) {
        if (status.state == net::SourceState::reconnecting) proxy.cut_after(0), proxy.throttle(0);
    };
    const Session session = open("mien://127.0.0.1:" + std::to_string(proxy.port()) + "/take", wanted);
    const auto frame = session.decode->wait_pop({});
    ASSERT_TRUE(frame);
    FaceView face(*session.stream);
    face.show(*frame);
    EXPECT_TRUE(wait_until([&] { return refine(session, face), picture(face).pixels == whole.pixels; }));
    EXPECT_GE(session.source->statistics().reconnects, 1u) << "although nothing of the stream itself is missing";
    EXPECT_EQ(session.source->statistics().blobs_fetched, served.stream.blobs.size());
}

TEST_F(RefinerGLTest, ARefinementThatDoesNotDecodeIsToldAndTheLastGoodStageStays) {
    // The hash is right, and what it names is nonsense.
    Stream stream = driven_stream();
    const auto refinements = refinements_of(stream);
    const auto bad = std::ranges::find(stream.blobs, refinements[0].hash, &protocol::StaticBlob::hash);
    auto manifest = protocol::parse_manifest(stream.blobs[0].bytes);
    ASSERT_TRUE(manifest.ok());
    *bad = protocol::sample::make_blob(protocol::BlobKind::refinement, protocol::sample::literal({1, 0}));
    for (protocol::Layer& layer : manifest->layers) std::ranges::replace(layer.blobs, refinements[0].hash, bad->hash);
    stream.blobs[0] = protocol::sample::make_blob(protocol::BlobKind::manifest, protocol::encode_manifest(*manifest));
    stream.header.model = stream.blobs[0].hash;
    const Served served(stream);
    const Session session = open(to_string(served.url()));
    const auto frame = session.decode->wait_pop({});
    ASSERT_TRUE(frame);
    FaceView face(*session.stream);
    face.show(*frame);
    const Image first = picture(face);
    ASSERT_TRUE(wait_until([&] { return !session.unrefined().empty(); }));
    EXPECT_NE(session.unrefined().find("the detail of the face stays as it is"), std::string::npos) << session.unrefined();
    refine(session, face);
    EXPECT_EQ(picture(face).pixels, first.pixels);
    for (std::int64_t f = 1; f < std::int64_t(stream.header.frames); ++f) {
        const auto next = session.decode->wait_pop({});
        ASSERT_TRUE(next) << f;
        EXPECT_EQ(next->frame, f);
    }
}

TEST_F(RefinerGLTest, MapsGoToTheGpuALittleAtATimeAndAreDrawnWhenAllAreThere) {
    const Stream stream = driven_stream();
    const auto decode = [&](bool refined) {
        auto face = decoder::decode_model(stream.header.model, [&](const Hash& hash) -> const Bytes* {
            const auto found = std::ranges::find(stream.blobs, hash, &protocol::StaticBlob::hash);
            return found == stream.blobs.end() || (!refined && found->kind == protocol::BlobKind::refinement) ? nullptr : &found->bytes;
        });
        EXPECT_TRUE(face.ok());
        return std::move(*face);
    };
    const model::FaceModel coarse = decode(false), fine = decode(true);
    const auto coarse_maps = render::map_pictures(coarse.detail->model(), nullptr), fine_maps = render::map_pictures(fine.detail->model(), nullptr);
    render::DetailMap map(coarse.detail->model(), coarse_maps), wanted(fine.detail->model(), fine_maps);
    const std::size_t triangles = coarse.detail->model().marker_triangles.size();
    const std::vector<float> parameters(12 * triangles, 0.3f);
    const auto buffer = render::gl::make_buffer(sizeof(float) * parameters.size(), parameters.data());
    const auto texels = render::gl::make_texels(GL_RGBA32F, buffer);
    const auto values = [&](render::DetailMap& of) { return of.evaluate(texels, 1), of.read().values; };
    const std::vector<float> before = values(map), after = values(wanted);
    ASSERT_NE(before, after);
    int steps = 0;
    for (;; ++steps) {
        std::size_t budget = 5000;
        if (map.take(fine_maps, budget)) break;
        EXPECT_LT(budget, 5000u) << "every step brings some";
        ASSERT_EQ(values(map), before) << "step " << steps;
        ASSERT_LT(steps, 1000);
    }
    EXPECT_GT(steps, 10);
    EXPECT_EQ(values(map), after);
}

}  // namespace
}  // namespace mien::player
