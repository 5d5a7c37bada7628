// Input from a file in place of hands, the same each time: for tests, pictures and videos.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace viewer {

/// One a line; # begins a comment. Places are in the window's units.
///
///     wait                        until nothing is being built or drawn
///     key ctrl+S                  press and release
///     hold W 0.5                  for so many seconds
///     drag left 100 100 300 150   button, from, to; shift+left, right, middle
///     click 100 100
///     wheel 3 100 100             steps, where
///     drop FILE
///     set variant color-cube      also renderer, samples, threads, tolerance, error (a number, any or point-sampling),
///                                 budget (milliseconds or none), difference (flip or absolute), dividers (two numbers)
///     screenshot FILE.png
///     record FILE.json            until the next line `stop`
///     stop
///     play FILE.json              a path, to its end
///     quit
struct ScriptLine {
    int number = 0;
    std::vector<std::string> words;  ///< at least one
    std::string text;
};

/// Throws std::runtime_error that names file and line for what is no command or has too few words.
std::vector<ScriptLine> read_script(const std::filesystem::path& file);

}  // namespace viewer
