/// Whether others than the user could put something at a path.
#pragma once

#include <filesystem>
#include <string>

namespace deform {

/// Why what an absolute path leads to may be another's: "is …", about the path or about a folder on
/// the way, which is named; empty where only root and the user of this process decide. On the way
/// are all folders from the root, those of symbolic links and of their targets too. All of them
/// must be root's or the user's, and nobody else may write them; but sticky ones (/tmp), where
/// everybody keeps what is his, may lead on to what is root's or the user's. A group may write
/// where it is the primary one of the owner and of nobody else, has no other member, and no access
/// control list names others. OpenSSH's StrictModes is the model. What is not there is told, too.
[[nodiscard]] std::string objection_to(const std::filesystem::path& path);

}  // namespace deform
