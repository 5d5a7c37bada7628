// Runs a fuzzer without libFuzzer: what lies in folders, the same with bytes changed, and inputs of random numbers.
//
//     fuzz_draw [FILE|FOLDER]... [--mutated COUNT] [--random COUNT] [--seed SEED] [--bytes MOST]
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
#include <string_view>
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

/// Up to eight changes: other bytes, what is in the way of readers, a piece left out, twice, or from another input.
Bytes mutated(const std::vector<Bytes>& corpus, farfield::test::Random& random) {
    const auto any = [&](std::size_t below) {
        return std::size_t{random.below(std::uint32_t(std::max<std::size_t>(below, 1)))};
    };
    constexpr std::string_view pieces[] = {
        "0", "-1", "1e39", "1e-300", "nan",  "inf", "4294967296", "99999999999999999999", " ", "\n", "\r", "#",
        "{", "}",  "\"",   "/",      "\\\n", ",",   ".5",         "\xff\xff\xff\xff"};
    Bytes bytes = corpus[any(corpus.size())];
    for (std::size_t left = 1 + any(8); left > 0; --left) {
        const std::size_t at = any(bytes.size() + 1), count = std::min(any(16), bytes.size() - at);
        const auto begin = bytes.begin() + std::ptrdiff_t(at);
        switch (any(5)) {
            case 0:
                for (std::size_t i = 0; i < count; ++i) bytes[at + i] = std::uint8_t(random.bits() >> 56);
                break;
            case 1: {
                const std::string_view piece = pieces[any(std::size(pieces))];
                bytes.insert(bytes.erase(begin, begin + std::ptrdiff_t(any(3) ? std::min(piece.size(), count) : 0)),
                             piece.begin(), piece.end());
                break;
            }
            case 2:
                bytes.erase(begin, begin + std::ptrdiff_t(count));
                break;
            case 3: {
                const Bytes piece(begin, begin + std::ptrdiff_t(count));
                bytes.insert(begin, piece.begin(), piece.end());
                break;
            }
            default: {
                const Bytes& other = corpus[any(corpus.size())];
                const std::size_t from = any(other.size() + 1);
                const std::size_t length = std::min(any(64), other.size() - from);
                bytes.insert(begin, other.begin() + std::ptrdiff_t(from),
                             other.begin() + std::ptrdiff_t(from + length));
            }
        }
    }
    return bytes;
}

bool replay(const std::filesystem::path& path, std::vector<Bytes>& corpus) {
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
        corpus.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
        all_pass = passes(corpus.back(), file.string()) && all_pass;
    }
    std::printf("%zu files of %s\n", files.size(), path.string().c_str());
    return all_pass;
}

}  // namespace

int main(int argc, char** argv) {
    std::uint64_t count = 0, mutations = 0, seed = 1, most = 1024;
    std::vector<Bytes> corpus;
    bool all_pass = true;
    for (int i = 1; i < argc; ++i) {
        const std::string word = argv[i];
        const auto number = [&] { return i + 1 < argc ? std::strtoull(argv[++i], nullptr, 10) : 0; };
        if (word == "--mutated") {
            mutations = number();
        } else if (word == "--random") {
            count = number();
        } else if (word == "--seed") {
            seed = number();
        } else if (word == "--bytes") {
            most = std::max<std::uint64_t>(number(), 1);
        } else if (std::filesystem::exists(word)) {
            all_pass = replay(word, corpus) && all_pass;
        } else {
            std::fprintf(stderr, "%s: no such file, folder or option: %s\n", argv[0], word.c_str());
            return 2;
        }
    }
    if (corpus.empty()) mutations = 0;
    for (std::uint64_t i = 0; i < mutations + count; ++i) {
        farfield::test::Random random(seed + i);
        Bytes bytes;
        if (i < mutations) {
            bytes = mutated(corpus, random);
        } else {
            bytes.resize(1 + random.below(std::uint32_t(most)));
            for (std::uint8_t& b : bytes) b = std::uint8_t(random.bits() >> 56);
        }
        const std::string name = "finding-" + std::to_string(seed + i);
        if (passes(bytes, name)) continue;
        std::ofstream(name, std::ios::binary)
            .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
        all_pass = false;
    }
    std::printf("%llu changed and %llu random inputs\n", static_cast<unsigned long long>(mutations),
                static_cast<unsigned long long>(count));
    return all_pass ? 0 : 1;
}
