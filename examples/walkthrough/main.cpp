// Flies through a scene, or looks at it from a distance, and draws every frame exactly and with far fields: pictures,
// differences, and a table of what each variant costs and gains. See --help.
#include <unistd.h>

#include <exception>
#include <fstream>
#include <iostream>
#include <new>

#include "flight.hpp"
#include "options.hpp"
#include "pages.hpp"
#include "report/picture.hpp"
#include "result.hpp"
#include "run.hpp"
#include "setting.hpp"

namespace {

void make_writable(const std::filesystem::path& directory) {
    std::error_code error;
    std::filesystem::create_directories(directory, error);
    if (error || !std::filesystem::is_directory(directory)) {
        throw walkthrough::UsageError("cannot make the directory " + directory.string());
    }
    if (::access(directory.c_str(), W_OK | X_OK) != 0) {
        throw walkthrough::UsageError("cannot write into the directory " + directory.string());
    }
}

/// Before the long work, not after it.
void check_writable(const walkthrough::Options& options) {
    if (options.out_directory) make_writable(*options.out_directory);
    if (options.json_file && !std::ofstream(*options.json_file, std::ios::app)) {
        throw walkthrough::UsageError("cannot write " + options.json_file->string());
    }
}

void walk(const walkthrough::Options& options) {
    using namespace walkthrough;
    if (is_paged(options.scene)) {
        if (options.copies != 1) throw UsageError("--copies is for scenes in memory");
        if (options.path) throw UsageError("--path is for scenes in memory: a file of pages is walked into");
        check_writable(options);
        walk_pages(std::cout, options);
        if (!std::cout.flush()) throw UsageError("cannot write to the standard output");
        return;
    }
    if (options.measures_errors) throw UsageError("--measure is for files of pages: in memory, every run measures");
    const Setting setting = make_setting(options.scene, options.up, std::uint32_t(options.copies));
    check_writable(options);
    std::vector<Result> results;
    try {
        results = run(setting, options, plan_flight(setting, options));
    } catch (const UsageError&) {
        throw;
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& error) {
        throw UsageError("cannot draw '" + options.scene + "': " + error.what());
    }
    print_table(std::cout, setting, options, results);
    if (options.json_file) write_json(*options.json_file, setting, options, results);
    if (options.out_directory) {
        std::cout << "pictures: " << options.out_directory->string() << " (differences are amplified "
                  << farfield::report::difference_gain << " times)\n";
    }
    if (options.json_file) std::cout << "table: " << options.json_file->string() << "\n";
    if (!std::cout.flush()) throw UsageError("cannot write to the standard output");
}

}  // namespace

/// Whatever goes wrong ends with one line and status 2: nothing that a file, an option or a machine does is a reason to
/// end without a word.
int main(int argc, char** argv) {
    try {
        std::string answer;
        if (const auto options = walkthrough::parse_options(argc, argv, answer)) {
            walk(*options);
        } else {
            std::cout << answer;
        }
        return 0;
    } catch (const std::bad_alloc&) {
        std::cerr << "walkthrough: there is not enough memory for this scene, variant and size of image\n";
    } catch (const std::exception& error) {
        std::cerr << "walkthrough: " << error.what() << "\n";
    }
    return 2;
}
