// Runs a fuzzer without libFuzzer: what lies in folders, and inputs of random numbers.
//
//     fuzz_draw [FILE|FOLDER]... [--random COUNT] [--seed SEED] [--bytes MOST]
//
// Ends with status 1 at the first finding, whose bytes it leaves in a file finding-SEED.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <vector>

#include "fuzz/fuzz.hpp"
#include "support/random.hpp"

namespace {

using Bytes = std::vector<std::uint8_t>;

bool passes(const Bytes& bytes, const std::string& name) {
    try {
        farfield::fuzz::run(bytes);
        return true;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "%s: %s\n", name.c_str(), e.what());
        return false;
    }
}

bool replay(const std::filesystem::path& path) {
    std::vector<std::filesystem::path> files{path};
    if (std::filesystem::is_directory(path)) {
        files.clear();
        for (const auto& entry : std::filesystem::recursive_directory_iterator(path)) {
            if (entry.is_regular_file()) files.push_back(entry.path());
        }
        std::sort(files.begin(), files.end());
    }
    bool all_pass = true;
    for (const auto& file : files) {
        std::ifstream in(file, std::ios::binary);
        const Bytes bytes{std::istreambuf_iterator<char>(in), {}};
        all_pass = passes(bytes, file.string()) && all_pass;
    }
    std::printf("%zu files of %s\n", files.size(), path.string().c_str());
    return all_pass;
}

}  // namespace

int main(int argc, char** argv) {
    std::uint64_t count = 0, seed = 1, most = 1024;
    bool all_pass = true;
    for (int i = 1; i < argc; ++i) {
        const std::string word = argv[i];
        const auto number = [&] { return i + 1 < argc ? std::strtoull(argv[++i], nullptr, 10) : 0; };
        if (word == "--random") {
            count = number();
        } else if (word == "--seed") {
            seed = number();
        } else if (word == "--bytes") {
            most = std::max<std::uint64_t>(number(), 1);
        } else if (std::filesystem::exists(word)) {
            all_pass = replay(word) && all_pass;
        } else {
            std::fprintf(stderr, "%s: no such file, folder or option: %s\n", argv[0], word.c_str());
            return 2;
        }
    }
    for (std::uint64_t i = 0; i < count; ++i) {
        farfield::test::Random random(seed + i);
        Bytes bytes(1 + random.below(std::uint32_t(most)));
        for (std::uint8_t& b : bytes) b = std::uint8_t(random.bits() >> 56);
        const std::string name = "finding-" + std::to_string(seed + i);
        if (passes(bytes, name)) continue;
        std::ofstream(name, std::ios::binary)
            .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
        all_pass = false;
    }
    if (count > 0) std::printf("%llu random inputs\n", static_cast<unsigned long long>(count));
    return all_pass ? 0 : 1;
}
