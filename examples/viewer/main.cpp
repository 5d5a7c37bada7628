// Flies through a scene in a window, and shows what its far fields cost and gain. See --help, and F1 in the window.
#include <CLI/CLI.hpp>
#include <exception>
#include <iostream>
#include <new>
#include <string>
#include <vector>

#include "application.hpp"

namespace {

/// Nothing where only help was asked for.
std::optional<viewer::Options> parse(int argc, const char* const* argv) {
    viewer::Options options;
    std::string size, script, path;
    CLI::App app("Flies through a scene in a window; F1 there tells keys and mouse.", "viewer");
    app.add_option("scene", options.scene,
                   "a generated scene, a file that the walkthrough takes, or a file of pages, here or at an http:// "
                   "address")
        ->capture_default_str();
    std::vector<std::string> values(5);
    const char* const names[] = {"variant", "renderer", "samples", "threads", "tolerance"};
    for (std::size_t i = 0; i < values.size(); ++i) app.add_option("--" + std::string(names[i]), values[i]);
    app.add_option("--size", size, "of the window")->type_name("WIDTHxHEIGHT");
    app.add_option("--cache", options.cache_mib, "MiB for pages")->type_name("MIB");
    app.add_option("--play", path, "fly a path that was recorded")->type_name("FILE");
    app.add_option("--script", script, "input from a file, see script.hpp")->type_name("FILE");
    try {
        app.parse(argc, argv);
    } catch (const CLI::CallForHelp&) {
        std::cout << app.help();
        return std::nullopt;
    } catch (const CLI::ParseError& error) {
        throw std::runtime_error(error.what());
    }
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (!values[i].empty()) options.choices.push_back({names[i], values[i]});
    }
    if (!size.empty()) {
        int used = 0;
        const bool is_size = std::sscanf(size.c_str(), "%dx%d%n", &options.size.x, &options.size.y, &used) == 2;
        const auto fits = [](int side) { return side >= 64 && side <= 8192; };
        if (!is_size || std::size_t(used) != size.size() || !fits(options.size.x) || !fits(options.size.y)) {
            throw std::runtime_error("--size must be WIDTHxHEIGHT, each from 64 to 8192, not '" + size + "'");
        }
    }
    if (!script.empty()) options.script = script;
    if (!path.empty()) options.path = path;
    return options;
}

}  // namespace

/// Whatever goes wrong ends with one line and status 2.
int main(int argc, char** argv) {
    try {
        if (const auto options = parse(argc, argv)) viewer::Application(*options).run();
        return 0;
    } catch (const std::bad_alloc&) {
        std::cerr << "viewer: there is not enough memory\n";
    } catch (const std::exception& error) {
        std::cerr << "viewer: " << error.what() << "\n";
    }
    return 2;
}
