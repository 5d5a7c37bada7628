// Arrays that are larger than memory: whatever a program allocates in large blocks lies in temporary files.
#pragma once

#include <cstdint>
#include <filesystem>

namespace farfield::scenes {

/// While one is there every block of 4 MiB or more that `new` gives, a vector's above all, is a mapped file in a
/// folder, which nobody else sees and which goes with the block, however long it lives. So the readers of all formats,
/// which keep a file and what they make of it in arrays, need no more memory than 4 MiB for each of some tens of
/// arrays: the system writes what has not been looked at for long to the disk and takes its memory for other things.
/// The disk needs room for the file as text, and for about 200 bytes a triangle. Where the folder's disk is full `new`
/// says that there is no memory, and error_of_files() why. Does nothing where the system maps no files.
///
/// It is for programs that need their memory for something else, as a build within 256 MiB does, and is slower than
/// memory, above all for arrays that come and go: a build's own are to be made when it has gone.
class LargeBlocksInFiles {
  public:
    explicit LargeBlocksInFiles(const std::filesystem::path& folder);
    ~LargeBlocksInFiles();
    LargeBlocksInFiles(const LargeBlocksInFiles&) = delete;
    LargeBlocksInFiles& operator=(const LargeBlocksInFiles&) = delete;
};

/// Why the system gave no file for the last block that was refused one: its errno, or 0 if none was.
int error_of_files();
/// Bytes of blocks that lie in files now.
std::uint64_t bytes_in_files();

}  // namespace farfield::scenes
