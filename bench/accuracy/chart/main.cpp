// Charts speed against accuracy for every variant. See --help.
#include <exception>
#include <fstream>
#include <iostream>

#include "accuracy.hpp"
#include "equal_error_table.hpp"
#include "gnuplot.hpp"
#include "growth.hpp"
#include "html.hpp"
#include "interrupt.hpp"
#include "options.hpp"
#include "pictures.hpp"

namespace {

using namespace farfield::bench;

/// Before the long work, not after it.
void make_directory(const std::filesystem::path& directory) {
    std::error_code error;
    std::filesystem::create_directories(directory / point_pictures, error);
    if (error) throw UsageError("cannot make the directory " + directory.string());
}

std::vector<Row> read(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    if (!in) throw UsageError("cannot read " + file.string());
    try {
        return read_csv(in);
    } catch (const std::invalid_argument& error) {
        throw UsageError(file.string() + " is not a chart: " + error.what());
    }
}

std::vector<Row> measure(const Options& options) {
    std::vector<const AnyVariant*> variants{&all_variants().front()};
    for (const std::string& name : options.variants) {
        for (const AnyVariant& variant : all_variants()) {
            if (variant.name == name && &variant != variants.front()) variants.push_back(&variant);
        }
    }
    Output output(options.directory / "chart.csv");
    catch_interrupts();
    Schedule schedule;
    AccuracyRun accuracy(options, variants, output, schedule);
    GrowthRun growth(options, variants, output, schedule);
    for (const std::string& scene : options.scenes) schedule.plan(accuracy.guess_seconds(scene));
    for (const std::string& series : options.growth) schedule.plan(growth.guess_seconds(series));
    for (const std::string& scene : options.scenes) {
        if (!was_interrupted()) accuracy.measure(scene);
    }
    for (const std::string& series : options.growth) {
        if (!was_interrupted()) growth.measure(series);
    }
    schedule.begin(was_interrupted() ? "cut short; drawing what there is" : "drawing charts", 0);
    return output.rows();
}

void print(const Table& table) {
    for (const auto& row : table.rows) {
        for (std::size_t i = 0; i < row.size(); ++i) std::cout << (i == 0 ? "" : " | ") << row[i].text;
        std::cout << "\n";
    }
}

void chart(const Options& options) {
    make_directory(options.directory);
    const std::vector<Row> rows = options.from_csv ? read(*options.from_csv) : measure(options);
    const std::filesystem::path csv = options.directory / "chart.csv";
    std::error_code none_yet;
    if (options.from_csv && !std::filesystem::equivalent(*options.from_csv, csv, none_yet)) {
        std::filesystem::copy_file(*options.from_csv, csv, std::filesystem::copy_options::overwrite_existing);
    }
    const std::vector<Chart> charts = charts_of(rows);
    const std::string complaint = draw_charts(charts, options.directory);
    if (!complaint.empty()) std::cerr << "chart: " << complaint << "\n";
    write_html(rows, charts, options.directory);
    std::cout << "at equal error, RMSE\n";
    print(equal_error_table(rows, &Row::rmse, rmse_bound));
    std::cout << "at equal error, FLIP\n";
    print(equal_error_table(rows, &Row::flip, flip_bound));
    std::cout << "every point, its numbers and its picture, in a browser: "
              << (options.directory / "index.html").string() << "\n";
}

}  // namespace

int main(int argc, char** argv) {
    try {
        std::string answer;
        if (const auto options = parse_options(argc, argv, answer)) {
            chart(*options);
        } else {
            std::cout << answer;
        }
        return 0;
    } catch (const UsageError& error) {
        std::cerr << "chart: " << error.what() << "\n";
        return 2;
    } catch (const std::exception& error) {
        std::cerr << "chart: " << error.what() << "\n";
        return 1;
    }
}
