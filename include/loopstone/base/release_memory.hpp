#pragma once

namespace loopstone {

/// Gives back to the system what the allocator holds but nobody uses, where the allocator can:
/// between two stages of work, so that the second does not come on top of what the first left in
/// pieces. Cost: about a millisecond for 100 MB.
void release_unused_memory();

/// For a process that runs for days, before it has threads: large blocks go back to the system as
/// soon as they are free, and threads share what is left in pieces, where the allocator can do so.
/// What threads free and large blocks leave behind is otherwise as much as the data themselves.
/// Cost: some microseconds for each large block.
void keep_memory_compact();

}  // namespace loopstone
