// mien-look MESH.obj [TEXTURE] -o out.png: what a mesh looks like in the player's light, from some sides.
#include <CLI/CLI.hpp>
#include <chrono>
#include <ctime>
#include <cstdio>
#include <cstring>

#include "core/environment_error.hpp"
#include "io/image_file.hpp"
#include "io/obj.hpp"
#include "render/still.hpp"

using namespace mien;

namespace {

Image side_by_side(const std::vector<Image>& images) {
    Image sheet(0, images.front().height, 3);
    for (const Image& image : images) sheet.width += image.width;
    sheet.pixels.resize(std::size_t(sheet.width) * sheet.height * 3);
    int x = 0;
    for (const Image& image : images) {
        for (int y = 0; y < image.height; ++y)
            std::memcpy(sheet.at(x, y), image.at(0, y), std::size_t(image.width) * 3);
        x += image.width;
    }
    return sheet;
}

}  // namespace

int main(int argc, char** argv) try {
    CLI::App app("Draws a mesh file from one or more sides");
    std::string mesh_path, texture_path, output = "look.png";
    std::vector<std::string> views = {"front"};
    double unit = 1, zoom = 1, yaw = 0, pitch = 0, up = 0, right = 0;
    int width = 640, height = 720, repeat = 0;
    render::Smoothing smoothing = render::Smoothing::supersample;
    bool wireframe = false, unlit = false, no_shadows = false;
    app.add_option("mesh", mesh_path, "OBJ file")->required();
    app.add_option("texture", texture_path, "PNG or JPEG");
    app.add_option("-o,--output", output);
    app.add_option("--view", views, "front, left, right: one picture each, side by side");
    app.add_option("--unit", unit, "millimetres per unit of the file");
    app.add_option("--zoom", zoom, "closer by this factor");
    app.add_option("--yaw", yaw, "degrees beyond the view");
    app.add_option("--pitch", pitch, "degrees");
    app.add_option("--up", up, "aim higher by mm");
    app.add_option("--right", right, "aim to the right by mm");
    app.add_option("--width", width);
    app.add_option("--height", height);
    app.add_option("--smoothing", smoothing, "none, edges, multisample or supersample")->transform(CLI::CheckedTransformer(
        std::map<std::string, render::Smoothing>{{"none", render::Smoothing::none},
                                                 {"edges", render::Smoothing::edges},
                                                 {"multisample", render::Smoothing::multisample},
                                                 {"supersample", render::Smoothing::supersample}}));
    app.add_option("--repeat", repeat, "draw this often and print the time");
    app.add_flag("--wireframe", wireframe);
    app.add_flag("--unlit", unlit, "albedo only");
    app.add_flag("--no-shadows", no_shadows);
    CLI11_PARSE(app, argc, argv);

    auto mesh = io::read_obj(mesh_path);
    if (!mesh.ok()) return std::fprintf(stderr, "%s\n", mesh.error().message.c_str()), 1;
    mesh->positions *= float(unit);
    render::StillRenderer still(*mesh);
    if (!texture_path.empty()) {
        auto texture = io::read_image(texture_path);
        if (!texture.ok()) return std::fprintf(stderr, "%s\n", texture.error().message.c_str()), 1;
        still.set_texture(*texture);
    }
    render::Look look;
    look.wireframe = wireframe;
    look.lit = !unlit;
    look.shadows = !no_shadows;
    const Eigen::AlignedBox3f box = render::bounding_box(mesh->positions);
    std::vector<Image> pictures;
    for (const std::string& name : views) {
        const auto view = render::parse_view(name);
        if (!view) return std::fprintf(stderr, "no such view: %s\n", name.c_str()), 1;
        render::OrbitCamera orbit = render::frame_box(box, float(width) / float(height), *view);
        orbit.orbit(float(yaw * M_PI / 180), float(pitch * M_PI / 180));
        orbit.pan = Vec2(float(-right), float(-up));
        orbit.distance /= float(zoom);
        pictures.push_back(still.picture(orbit.camera(), width, height, look, smoothing));
        if (repeat > 0) {
            const auto start = std::chrono::steady_clock::now();
            const std::clock_t cpu = std::clock();
            for (int i = 0; i < repeat; ++i) still.picture(orbit.camera(), width, height, look, smoothing);
            const std::chrono::duration<double, std::milli> spent = std::chrono::steady_clock::now() - start;
            std::printf("%s: %.1f ms a picture, %.1f ms of all cores\n", name.c_str(), spent.count() / repeat,
                        1e3 * double(std::clock() - cpu) / CLOCKS_PER_SEC / repeat);
        }
    }
    io::write_image(output, side_by_side(pictures));
    return 0;
} catch (const EnvironmentError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
