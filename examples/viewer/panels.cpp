#include "panels.hpp"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <cfloat>
#include <cstdint>
#include <cstdio>
#include <thread>

#include "scenes/catalog.hpp"
#include "scenes/how_drawn.hpp"

namespace viewer {
namespace {

using farfield::FrameStats;
using farfield::scenes::renderer_kinds;
using farfield::scenes::RendererKind;

void tip(const char* text) {
    if (ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled)) ImGui::SetTooltip("%s", text);
}

void number(const char* what, std::uint64_t value) {
    if (value == 0) return;
    ImGui::Text("%-18s %12llu", what, static_cast<unsigned long long>(value));
}

void choose_scene(const Shown& shown, Clicked& clicked) {
    const std::string name = shown.stage != nullptr ? shown.stage->name : "";
    if (ImGui::BeginCombo("scene", name.c_str())) {
        for (const std::string& each : farfield::scenes::names()) {
            if (ImGui::Selectable(each.c_str(), each == name)) clicked.open = each;
        }
        ImGui::EndCombo();
    }
    tip("or drop a file onto the window");
    if (shown.stage == nullptr) return;
    ImGui::TextDisabled("%s", shown.stage->what.c_str());
    for (const std::string& note : shown.stage->notes) ImGui::TextWrapped("%s", note.c_str());
}

void choose_variant(Look& look, const Shown& shown) {
    if (shown.stage == nullptr) return;
    const auto& variants = shown.stage->variants;
    if (ImGui::BeginCombo("variant", variants[look.variant].name.c_str())) {
        for (std::size_t i = 0; i < variants.size(); ++i) {
            if (ImGui::Selectable(variants[i].name.c_str(), i == look.variant)) look.variant = i;
            tip(variants[i].description.c_str());
        }
        ImGui::EndCombo();
    }
    tip(variants[look.variant].description.c_str());
    if (shown.variant) {
        const auto& facts = shown.variant->facts();
        ImGui::TextDisabled("built in %.2f s: %llu cells, %.1f MB", facts.seconds,
                            static_cast<unsigned long long>(facts.cells), 1e-6 * double(facts.bytes));
    }
}

void choose_renderer(Look& look, const Shown& shown) {
    if (ImGui::BeginCombo("renderer", name_of(look.renderer).data())) {
        for (const RendererKind kind : renderer_kinds) {
            const std::string obstacle =
                shown.stage != nullptr ? shown.stage->variants[look.variant].obstacle(kind) : std::string();
            ImGui::BeginDisabled(!obstacle.empty());
            if (ImGui::Selectable(name_of(kind).data(), kind == look.renderer)) look.renderer = kind;
            ImGui::EndDisabled();
            if (!obstacle.empty()) tip(obstacle.c_str());
        }
        ImGui::EndCombo();
    }
    static constexpr std::array samples{1, 4, 9, 16, 64};
    if (ImGui::BeginCombo("samples", std::to_string(look.samples).c_str())) {
        for (const int each : samples) {
            if (look.renderer == RendererKind::coverage && each != 1 && each != 64) continue;
            if (ImGui::Selectable(std::to_string(each).c_str(), each == look.samples)) look.samples = each;
        }
        ImGui::EndCombo();
    }
    ImGui::SliderInt("threads", &look.threads, 1, int(std::max(1u, std::thread::hardware_concurrency())));
}

void choose_quality(Look& look) {
    constexpr ImGuiSliderFlags log = ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp;
    ImGui::SliderFloat("tolerance", &look.tolerance_px, 0.125f, 64, "%.2f px", log);
    tip("a stand-in is drawn where its outline is off by no more; [ and ]");
    static constexpr std::array wanted{"any", "point sampling's", "at most"};
    if (ImGui::BeginCombo("error", wanted[std::size_t(look.wanted)])) {
        for (std::size_t i = 0; i < wanted.size(); ++i) {
            if (ImGui::Selectable(wanted[i], Wanted(i) == look.wanted)) look.wanted = Wanted(i);
        }
        ImGui::EndCombo();
    }
    tip("nothing stands in that is expected to err more");
    if (look.wanted == Wanted::value) ImGui::SliderFloat("rmse", &look.wanted_rmse, 0.001f, 0.5f, "%.3f", log);
    ImGui::Checkbox("budget", &look.has_budget);
    tip("the best picture that so much time pays for; a view that stands is refined");
    if (look.has_budget) {
        ImGui::SameLine();
        ImGui::SliderFloat("##ms", &look.budget_ms, 2, 1000, "%.0f ms", log);
    }
}

void choose_picture(Look& look, Clicked& clicked, const Shown& shown) {
    ImGui::Checkbox("exact (space)", &look.shows_exact);
    ImGui::SameLine();
    ImGui::Checkbox("side by side (C)", &look.compares);
    ImGui::Checkbox("measure error", &look.measures_error);
    if (look.compares || look.measures_error) {
        int difference = int(look.difference);
        ImGui::Combo("difference", &difference, difference_names.data(), int(difference_names.size()));
        look.difference = Difference(difference);
    }
    ImGui::Checkbox("levels (L)", &look.tints_levels);
    tip("stand-ins by the depth of their cells, primitives in gray");
    ImGui::SameLine();
    ImGui::Checkbox("cells (O)", &look.outlines_cells);
    bool is_frozen = look.frozen.has_value();
    if (ImGui::Checkbox("freeze, look on from outside (Z)", &is_frozen)) {
        look.frozen.reset();
        if (is_frozen && shown.drawn != nullptr) look.frozen = shown.drawn->order.view.camera;
    }
    ImGui::Checkbox("fly: a drag turns the head (G)", &look.flies);
    clicked.frame = ImGui::Button("frame (F)");
    ImGui::SameLine();
    clicked.reset = ImGui::Button("reset (R)");
    ImGui::SameLine();
    clicked.screenshot = ImGui::Button("screenshot");
    clicked.record = ImGui::Button(shown.is_recording ? "stop (P)" : "record (P)");
    ImGui::SameLine();
    clicked.play = ImGui::Button(shown.is_playing ? "stop (K)" : "play (K)");
    tip("the path that was recorded last, or else a flight through the scene");
    ImGui::SameLine();
    if (ImGui::Button("help (F1)")) look.shows_help = !look.shows_help;
}

void plot(const char* what, const char* format, const History& history) {
    if (history.values().empty()) return;
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), format, double(history.last()));
    ImGui::TextUnformatted(text.data());
    ImGui::PlotLines(what, history.values().data(), int(history.values().size()), 0, nullptr, 0,
                     std::max(history.largest() * 1.1f, FLT_MIN), {-1, 40});
}

void show_levels(const FrameStats& stats) {
    for (unsigned level = 0; level < unsigned(FrameStats::max_levels); ++level) {
        if (stats.approximations_by_level[level] == 0) continue;
        const farfield::Rgba8 c = farfield::scenes::tint_of_level(level);
        ImGui::TextColored({float(c.r) / 255, float(c.g) / 255, float(c.b) / 255, 1}, "  level %2u %19llu", level,
                           static_cast<unsigned long long>(stats.approximations_by_level[level]));
    }
}

void show_stats(const Drawn& drawn) {
    const FrameStats& s = drawn.stats;
    number("primitives", s.primitives);
    number("stand-ins", s.approximations);
    show_levels(s);
    number("faces", s.faces);
    number("splats", s.splats);
    number("cached images", s.images);
    number("  made now", s.images_made);
    number("  bytes", s.image_bytes);
    number("instances", s.instances);
    number("cells visited", s.cells_visited);
    number("  outside", s.cells_outside);
    number("  hidden", s.cells_hidden);
    number("  too coarse", s.cells_too_coarse);
    number("  needing samples", s.cells_needing_samples);
    number("  cheaper exactly", s.cells_cheaper);
    number("  missing", s.cells_missing);
    number("bytes touched", s.touched_bytes);
}

void show_picked(const farfield::scenes::PickedInScene& picked) {
    std::string path;
    for (const std::uint32_t index : picked.path) path += (path.empty() ? "" : " > ") + std::to_string(index);
    ImGui::Separator();
    ImGui::TextColored({1, 0.9f, 0.3f, 1}, "primitive %s", path.c_str());
    ImGui::Text("at %.5g, %.5g, %.5g, depth %.4g", picked.point.x, picked.point.y, picked.point.z, picked.depth);
    for (const glm::dvec3& c : picked.corners) ImGui::TextDisabled("  %.5g, %.5g, %.5g", c.x, c.y, c.z);
    if (!picked.cell) return;
    ImGui::TextColored({0.3f, 0.9f, 1, 1}, "cell %u, level %u", picked.node, picked.cell->depth);
    ImGui::Text("%llu primitives in it and below", static_cast<unsigned long long>(picked.cell_primitives));
}

}  // namespace

Clicked show_panels(Look& look, const Shown& shown) {
    Clicked clicked;
    ImGui::SetNextWindowPos({10, 10}, ImGuiCond_FirstUseEver);
    ImGui::Begin("farfield", nullptr, ImGuiWindowFlags_AlwaysAutoResize);
    ImGui::PushItemWidth(170);
    choose_scene(shown, clicked);
    choose_variant(look, shown);
    choose_renderer(look, shown);
    choose_quality(look);
    ImGui::Separator();
    choose_picture(look, clicked, shown);
    ImGui::PopItemWidth();
    ImGui::End();

    if (shown.drawn == nullptr) return clicked;
    constexpr float width = 262;
    ImGui::SetNextWindowPos({float(shown.size.x) - width - 10, 10}, ImGuiCond_FirstUseEver);
    ImGui::SetNextWindowSize({width, 0}, ImGuiCond_Always);
    ImGui::Begin("frame", nullptr, ImGuiWindowFlags_NoResize);
    plot("##frame times", "frame %.1f ms", *shown.frame_ms);
    plot("##errors", look.difference == Difference::flip ? "mean FLIP %.4f" : "RMSE %.4f", *shown.errors);
    const Drawn& drawn = *shown.drawn;
    if (drawn.has_exact() && drawn.has_variant()) {
        ImGui::Text("exact %.1f ms, %.1f times that", drawn.exact_ms, drawn.exact_ms / drawn.variant_ms);
    }
    if (drawn.rmse >= 0) ImGui::Text("RMSE %.4f", drawn.rmse);
    if (drawn.order.side > 1) ImGui::TextDisabled("1/%d of the size while it moves", drawn.order.side);
    show_stats(drawn);
    if (*shown.picked) show_picked(**shown.picked);
    ImGui::End();
    return clicked;
}

void show_status(const Shown& shown) {
    if (shown.task.empty() && shown.message.empty()) return;
    ImGui::SetNextWindowPos({10, float(shown.size.y) - 10}, ImGuiCond_Always, {0, 1});
    ImGui::Begin("status", nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize |
                     ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoNav);
    if (!shown.message.empty()) ImGui::TextColored({1, 0.6f, 0.4f, 1}, "%s", shown.message.c_str());
    if (!shown.task.empty()) {
        ImGui::Text("%s", shown.task.c_str());
        if (shown.part >= 0) ImGui::ProgressBar(float(shown.part), {240, 0});
    }
    ImGui::End();
}

void show_help(Look& look) {
    static constexpr std::array<std::array<const char*, 2>, 20> lines{{
        {"left drag", "orbit; in fly mode turn the head"},
        {"right or shift drag", "pan"},
        {"wheel", "zoom to what the cursor is on"},
        {"W A S D, Q E", "walk, down and up; shift runs"},
        {"click", "tell what is there, and its cell"},
        {"F, R", "frame the scene, reset the view"},
        {"G", "fly mode"},
        {"space", "exact, or the variant"},
        {"C", "exact, variant and difference; drag the lines"},
        {"L", "tint stand-ins by level"},
        {"O", "outline cells"},
        {"Z", "freeze the frustum, look on from outside"},
        {"[ ]", "halve, double the tolerance"},
        {"P, K", "record a path, play it or a flight"},
        {"ctrl S", "screenshot"},
        {"H", "hide panels"},
        {"F1", "this help"},
        {"escape", "quit"},
        {"drop a file", "open it: models, point clouds, molecules,"},
        {"", "height fields, files of pages"},
    }};
    ImGui::SetNextWindowPos({310, 60}, ImGuiCond_FirstUseEver);
    ImGui::Begin("help", &look.shows_help, ImGuiWindowFlags_AlwaysAutoResize);
    for (const auto& [keys, what] : lines) ImGui::Text("%-20s %s", keys, what);
    ImGui::End();
}

}  // namespace viewer
