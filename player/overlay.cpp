#include "player/overlay.hpp"

#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <iterator>

#include "player/help_layout.hpp"

namespace mien::player {
namespace {

constexpr ImGuiWindowFlags kPlain = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs |
                                    ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoSavedSettings |
                                    ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoNav;

constexpr const char* kHelp[][2] = {
    {"space, p", "pause"},       {"left, right", "5 seconds"},  {"up, down", "1 minute"},     {"home", "the start"},
    {". ,", "one frame"},        {"[ ]", "speed"},              {"{ }", "half, double speed"}, {"backspace", "normal speed"},
    {"l", "loop"},               {"9 0", "volume"},             {"m", "mute"},                {"- +", "rung of texture"},
    {"a", "rung by the line"},   {"f", "full screen"},          {"i", "statistics"},          {"s", "screenshot"},
    {"w", "wireframe"},          {"1", "texture"},              {"2", "motion"},              {"3", "head pose"},
    {"4", "gaze"},               {"5", "light"},                {"6", "medium detail"},       {"7", "fine detail"},
    {"8", "learnt colour"},      {"r", "reset the view"},       {"h, ?, F1", "this help"},    {"q", "quit"},
    {"left mouse", "orbit"},     {"right mouse", "pan"},        {"wheel", "zoom"},            {"drop a file", "play it"},
};

/// Of the keys (0) or what they do (1).
float widest(int side) {
    float most = 0;
    for (const auto& entry : kHelp) most = std::max(most, ImGui::CalcTextSize(entry[side]).x);
    return most;
}

void draw_help(ImVec2 window, float scale) {
    const ImVec2 padding = ImGui::GetStyle().WindowPadding;
    const float gap = 14 * scale, keys = widest(0) + gap, column = keys + widest(1) + gap, row = 1.3f * ImGui::GetFontSize();
    const HelpLayout layout = fit_help(window.x - 2 * padding.x + gap, window.y - 2 * padding.y, int(std::size(kHelp)), column, row);
    ImGui::SetNextWindowPos({window.x / 2, window.y / 2}, ImGuiCond_Always, {0.5f, 0.5f});
    ImGui::SetNextWindowSize({(float(layout.columns) * column - gap) * layout.scale + 2 * padding.x, float(layout.rows) * row * layout.scale + 2 * padding.y});
    ImGui::SetNextWindowBgAlpha(0.8f);
    ImGui::Begin("help", nullptr, kPlain & ~ImGuiWindowFlags_AlwaysAutoResize);
    ImGui::SetWindowFontScale(layout.scale);
    for (int i = 0; i < int(std::size(kHelp)); ++i)
        for (const int side : {0, 1}) {
            ImGui::SetCursorPos({padding.x + (float(i / layout.rows) * column + float(side) * keys) * layout.scale, padding.y + float(i % layout.rows) * row * layout.scale});
            ImGui::TextUnformatted(kHelp[i][side]);
        }
    ImGui::End();
}

}  // namespace

Overlay::Overlay(GLFWwindow* window, float scale) : scale_(scale) {
    IMGUI_CHECKVERSION();
    ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;   // nothing of ours is to be remembered in the folder one happens to be in
    ImFontConfig font;
    font.SizePixels = 13 * std::max(1.0f, scale);
    io.Fonts->AddFontDefault(&font);
    ImGui::StyleColorsDark();
    ImGui::GetStyle().ScaleAllSizes(scale);
    ImGui_ImplGlfw_InitForOpenGL(window, false);
    ImGui_ImplOpenGL3_Init("#version 450 core");
}

Overlay::~Overlay() {
    ImGui_ImplOpenGL3_Shutdown();
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
}

void Overlay::draw(const Content& content) {
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    const float margin = 10 * scale_;
    if (!content.statistics.empty() && !content.help) {   // the help would lie over them
        ImGui::SetNextWindowPos({margin, margin});
        ImGui::SetNextWindowBgAlpha(0.55f);
        ImGui::Begin("statistics", nullptr, kPlain);
        for (const std::string& line : content.statistics) ImGui::TextUnformatted(line.c_str());
        ImGui::End();
    }
    if (content.help) draw_help(size, scale_);
    if (!content.message.empty()) {
        ImGui::SetNextWindowPos({size.x / 2, size.y - 46 * scale_}, ImGuiCond_Always, {0.5f, 1});
        ImGui::SetNextWindowBgAlpha(0.65f);
        ImGui::Begin("message", nullptr, kPlain);
        ImGui::PushTextWrapPos(size.x - 4 * margin);
        ImGui::TextUnformatted(content.message.c_str());
        ImGui::PopTextWrapPos();
        ImGui::End();
    }
    if (content.time_line >= 0) {
        ImDrawList* list = ImGui::GetForegroundDrawList();
        const float y = size.y - 14 * scale_, text = ImGui::CalcTextSize(content.clock.c_str()).x;
        const float left = margin, right = size.x - 2 * margin - text;
        const float at = left + (right - left) * float(std::min(1.0, content.time_line));
        list->AddLine({left, y}, {right, y}, IM_COL32(255, 255, 255, 60), 3 * scale_);
        list->AddLine({left, y}, {at, y}, IM_COL32(232, 168, 120, 230), 3 * scale_);
        list->AddCircleFilled({at, y}, 5 * scale_, IM_COL32(244, 214, 190, 255));
        list->AddText({size.x - margin - text, y - 7 * scale_}, IM_COL32(230, 230, 230, 220), content.clock.c_str());
    }
    if (content.live) {
        ImDrawList* list = ImGui::GetForegroundDrawList();
        const float y = size.y - 14 * scale_, text = ImGui::CalcTextSize("live").x;
        list->AddCircleFilled({size.x - 2 * margin - text, y}, 4 * scale_, IM_COL32(236, 84, 70, 255));
        list->AddText({size.x - margin - text, y - 7 * scale_}, IM_COL32(230, 230, 230, 220), "live");
    }
    ImGui::Render();
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

}  // namespace mien::player
