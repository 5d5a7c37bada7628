// Walks through scenes that are larger than memory: files of pages, as farfield_build makes them, here or on a web
// server.
#pragma once

#include <iosfwd>
#include <string>

#include "options.hpp"

namespace walkthrough {

/// A name that ends in .farfield, or an address that begins with http:// or https://.
bool is_paged(const std::string& scene);

/// Flies from above down to a twentieth of the scene's size and prints a table of what frames took, what was loaded for
/// them, and how far they are from frames that wait for everything. Variant, renderer and exact are not asked for: the
/// file has one variant, and what is exact does not fit. What tolerance and samples are chosen by is a table in the
/// file, if it has one that was measured at this size. Throws UsageError.
void walk_pages(std::ostream& out, const Options& options);

}  // namespace walkthrough
