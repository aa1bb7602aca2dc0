// The page docs/faults.md, made from the table of faults.
#include "scene/gltf/faults.h"
#include "commands.h"

#include <fmt/format.h>

namespace sightline {
namespace {

constexpr std::string_view page_head = R"(# Faults of files, and what is done about them

This page is made by `sightline faults`, from the table by which the program decides (`src/scene/gltf/faults.cpp`).

By default, Sightline draws what can be drawn. A fault costs the thing it is in (a texture, a camera, a primitive), not the
picture, and each fault is told in one warning: the place, what is wrong, what is done. What *is done* about a fault is

- *noted*: the file is sound; the warning says what the picture lacks, or how something was chosen;
- *mended*: a sound value takes the place of the faulty one;
- *dropped*: what has the fault is left out;
- *refused*: the file is not drawn: an error, and exit code 1.

`--strict` (of `render`, `batch` and `info`) refuses a file at its first fault that is mended or dropped. Faults of containers, of the
syntax of JSON and of buffers, and sizes above the limits, are errors in any case, because nothing behind them can be
trusted. `fault_count` and `faults` of `--stats` and of a batch's journal contain the faults that a picture met, by the keys below.
`sightline info` lists all faults of a file without rendering it: besides what the options choose, it reads every scene, every
variant's materials, every morph target, every animation and every image, also those that no pixel depends on.

The last columns tell what gltf-validator 2.0.0-dev.3.10 reports (errors, if nothing else is said) and what the GLTFLoader of
three.js 0.187 does; *fails* is an exception that ends the whole file. They were found with `tools/other_readers.mjs` on the files of
`tests/support/faulty_files.h`, which `scene_test` leaves in the folder of `Faults.EachRow…`, and on variants in which something uses
what has the fault. Whether a damaged image is read is left to the browser by three.js. [fault_survey.md](fault_survey.md) has the
answers for a corpus of files.

| fault | what is wrong | | what is done | Khronos' validator | three.js |
|---|---|---|---|---|---|
)";

std::string page() {
    std::string text(page_head);
    for (const FaultEntry& entry : fault_table())
        text += fmt::format("| `{}` | {} | {} | {} | {} | {} |\n", entry.key, entry.wrong,
                            to_string(entry.severity), entry.done, entry.validator, entry.three_js);
    return text;
}

}  // namespace

void add_faults_command(CLI::App& app) {
    CLI::App* sub = app.add_subcommand(
        "faults", "Print the table of faults and of what is done about them (docs/faults.md)");
    sub->callback([] { fmt::print("{}", page()); });
}

}  // namespace sightline
