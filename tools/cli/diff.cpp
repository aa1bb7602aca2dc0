#include "commands.h"
#include "image/compare.h"
#include "image/image.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <memory>

namespace sightline {
namespace {

struct DiffCommand {
    std::string reference;
    std::vector<std::string> pictures;
    bool json = false;
};

void run(const DiffCommand& command) {
    // EXRs with many layers are larger than environments.
    const ImageLimits limits{.max_file_bytes = uint64_t{1} << 32};
    const Image reference = read_image(command.reference, limits);
    auto list = nlohmann::ordered_json::array();
    for (const std::string& picture : command.pictures) {
        const Difference d = compare_images(reference, read_image(picture, limits));
        list.push_back({{"picture", picture},
                        {"rmse", d.rmse},
                        {"max_abs", d.max_abs},
                        {"flip_mean", d.flip_mean},
                        {"nonfinite", d.nonfinite}});
        if (!command.json)
            fmt::print("{}: rmse {:.6g}, largest {:.6g}, FLIP {:.6g}{}\n", picture, d.rmse,
                       d.max_abs, d.flip_mean,
                       d.nonfinite ? fmt::format(", {} values not finite", d.nonfinite) : "");
    }
    if (command.json) fmt::print("{}\n", list.dump(2));
}

}  // namespace

void add_diff_command(CLI::App& app) {
    const auto command = std::make_shared<DiffCommand>();
    CLI::App* sub = app.add_subcommand(
        "diff", "Measure how far pictures are from a reference: RMSE, largest difference, FLIP");
    sub->add_option("REFERENCE", command->reference, "Reference picture")
        ->required()
        ->type_name("FILE");
    sub->add_option("PICTURE", command->pictures, "Pictures to measure, of the same size and type")
        ->required()
        ->type_name("FILE");
    sub->add_flag("--json", command->json, "Print JSON");
    sub->footer("Try `sightline diff reference.png picture.png`.");
    sub->callback([command] { run(*command); });
}

}  // namespace sightline
