// What is known of a variant when it has been drawn, and how it is told.
#pragma once

#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "errors.hpp"
#include "farfield/tuning/sampled_error_table.hpp"
#include "options.hpp"
#include "scenes/built_scene.hpp"
#include "setting.hpp"

namespace walkthrough {

/// Means over all frames.
struct Drawn {
    double primitives = 0, approximations = 0, images = 0, cells_visited = 0, touched_bytes = 0;
    std::vector<double> approximations_by_level;  ///< up to the last that is not 0
};

/// Means over all frames, of coverage masks: how often cells of their pyramid are visited, a pixel of the picture.
struct CoverageCells {
    bool is_strict = false;  ///< polygons came in strict order
    double tiling = 0;       ///< for polygons
    double asking = 0;       ///< for questions whether a box is hidden
};

/// What a frame may be asked for: a tolerance and samples, and whether stand-ins keep to what is expected to err no
/// more than point sampling (View::wanted).
struct Choice : farfield::SampleChoice {
    bool asks_wanted = false;
};

/// Over the frames that are compared.
struct MeasuredErrors {
    farfield::SampledErrorTable by_tolerance;  ///< by the tolerance alone
    farfield::SampledErrorTable wanted;        ///< and by what is expected of each cell
    double exact_ms = 0;                       ///< mean of exact's frames in this run, at the fewest samples

    /// Of the two the one that costs less. Point sampling is exact at the fewest samples.
    Choice choice_for(farfield::WantedError error) const;
};

/// A plain loop over all triangles, over the frames that are compared.
struct PlainTime {
    double ms = 0, exact_ms = 0;  ///< means
    std::uint64_t triangles = 0, drawn_triangles = 0;
};

struct Result {
    std::string name;
    farfield::scenes::RendererKind renderer{};
    farfield::scenes::BuildFacts build;
    std::vector<double> frame_ms;  ///< in the order in which they were drawn
    /// Of exact and of the variant, of the same frames: all, each pair in turn, or where exact is slow only those that
    /// are compared.
    std::vector<double> exact_ms, paired_ms;
    std::optional<MeasuredErrors> measured;  ///< none where no tolerance was chosen
    std::optional<Choice> choice;            ///< from what was measured
    std::optional<PlainTime> plain;          ///< of the first result alone, which is exact's
    Drawn drawn;
    std::optional<CoverageCells> coverage;  ///< none of other renderers
    Errors errors;
};

/// The tolerance, or exact and why; with samples where they are chosen, too.
std::string words(const Choice& choice, bool tells_samples);

double mean(const std::vector<double>& values);
double median(std::vector<double> values);
/// Median exact frame over median frame, of those in pairs.
double speedup(const Result& result);

/// Aligned columns for people.
void print_table(std::ostream& out, const Setting& setting, const Options& options, const std::vector<Result>& results);

/// Throws std::runtime_error naming the file.
void write_json(const std::filesystem::path& file, const Setting& setting, const Options& options,
                const std::vector<Result>& results);

}  // namespace walkthrough
