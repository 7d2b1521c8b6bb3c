#include "deploy/cli/become.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "deploy/local/executables.h"

namespace dadrl {

Result<int> Become(std::string_view program, std::vector<std::string> arguments) {
  DADRL_ASSIGN_OR_RETURN(const auto path, FindExecutable(program));
  arguments.insert(arguments.begin(), path.string());
  std::vector<char*> words;
  for (std::string& argument : arguments) words.push_back(argument.data());
  words.push_back(nullptr);
  execv(path.c_str(), words.data());
  return Fail(ErrorCode::kInternal, "cannot start {}: {}", path.string(), std::strerror(errno));
}

}  // namespace dadrl
