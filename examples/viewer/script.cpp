#include "script.hpp"

#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string_view>

namespace viewer {
namespace {

struct Command {
    std::string_view name;
    std::size_t words;  ///< with its name
};
constexpr Command commands[] = {{"wait", 1},  {"key", 2},    {"hold", 3},      {"drag", 6}, {"click", 3},
                                {"wheel", 4}, {"drop", 2},   {"set", 3},       {"quit", 1}, {"stop", 1},
                                {"play", 2},  {"record", 2}, {"screenshot", 2}};

}  // namespace

std::vector<ScriptLine> read_script(const std::filesystem::path& file) {
    std::ifstream in(file);
    if (!in) throw std::runtime_error("cannot read " + file.string());
    std::vector<ScriptLine> lines;
    std::string text;
    for (int number = 1; std::getline(in, text); ++number) {
        std::istringstream rest(text.substr(0, text.find('#')));
        ScriptLine line{number, {}, text};
        for (std::string word; rest >> word;) line.words.push_back(word);
        if (line.words.empty()) continue;
        bool is_known = false;
        for (const Command& c : commands)
            is_known = is_known || (c.name == line.words[0] && line.words.size() >= c.words);
        if (!is_known) {
            throw std::runtime_error(file.string() + ", line " + std::to_string(number) + ": '" + text +
                                     "' is no command, or lacks words");
        }
        lines.push_back(std::move(line));
    }
    return lines;
}

}  // namespace viewer
