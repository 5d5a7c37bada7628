// The version of these headers, for #if. CMake reads it from here.
#pragma once

#define FARFIELD_VERSION_MAJOR 0
#define FARFIELD_VERSION_MINOR 1
#define FARFIELD_VERSION_PATCH 0

/// 10000 * major + 100 * minor + patch. Before 1.0 a new minor version may break its users.
#define FARFIELD_VERSION (10000 * FARFIELD_VERSION_MAJOR + 100 * FARFIELD_VERSION_MINOR + FARFIELD_VERSION_PATCH)
