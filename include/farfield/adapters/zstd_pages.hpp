// Pages packed by Zstandard (RFC 8878).
//
// It needs libzstd: in CMake link farfield::zstd, which is there where zstd is (of an installed farfield a component).
// No other header includes this one.
#pragma once

#include "farfield/settings.hpp"

#include <zstd.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "farfield/paging/packed_format.hpp"

namespace farfield {

/// Models PageCodec. Each thread that packs or unpacks keeps a context of zstd's until it ends: some 100 KiB for
/// unpacking, some MiB for packing, more at high levels.
struct ZstdPages {
    /// zstd's: 1 is fastest, 19 smallest; out of its range it is the nearest in it.
    int level = 3;

    static constexpr std::uint32_t file_tag = 0x5a535444u;  // "ZSTD"
    static constexpr const char* name = "zstd";

    std::size_t pack(std::span<const std::byte> from, std::span<std::byte> to) const {
        struct Free {
            void operator()(::ZSTD_CCtx* context) const { ::ZSTD_freeCCtx(context); }
        };
        static thread_local const std::unique_ptr<::ZSTD_CCtx, Free> context(::ZSTD_createCCtx());
        if (context == nullptr) return 0;
        const std::size_t size =
            ::ZSTD_compressCCtx(context.get(), to.data(), to.size(), from.data(), from.size(), level);
        return ::ZSTD_isError(size) != 0 ? 0 : size;
    }
    bool unpack(std::span<const std::byte> from, std::span<std::byte> to) const noexcept {
        struct Free {
            void operator()(::ZSTD_DCtx* context) const { ::ZSTD_freeDCtx(context); }
        };
        static thread_local const std::unique_ptr<::ZSTD_DCtx, Free> context(::ZSTD_createDCtx());
        return context != nullptr &&
               ::ZSTD_decompressDCtx(context.get(), to.data(), to.size(), from.data(), from.size()) == to.size();
    }
};

static_assert(PageCodec<ZstdPages>);

}  // namespace farfield
