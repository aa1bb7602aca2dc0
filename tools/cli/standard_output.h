#pragma once
#include <string>
#include <vector>

namespace sightline {

/// The output "-": a picture or film for standard output. Formats whose beginning is written last
/// need a file, so it is made in a private folder and copied when it is whole.
class StandardOutput {
  public:
    StandardOutput() = default;
    /// Removes the folder.
    ~StandardOutput();
    StandardOutput(const StandardOutput&) = delete;

    /// Puts the path of the file, with this ending, in the place of "-", if that is among the
    /// outputs. Throws CLI::ValidationError if it is there twice or if standard output is a
    /// terminal, Error if there is no place for the folder.
    void take(std::vector<std::string>& outputs, const std::string& format);

    /// Whether there is such an output. Then nothing else may be written to standard output.
    bool is_used() const { return !file_.empty(); }

    /// Copies the file. Throws Error, also if the reader has ended.
    void send() const;

  private:
    std::string folder_, file_;
};

}  // namespace sightline
