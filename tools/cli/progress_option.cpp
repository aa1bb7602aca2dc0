#include "progress_option.h"

#include "core/progress.h"
#include "options.h"

#include <string>

namespace sightline {

void add_progress_option(CLI::App& app) {
    app.add_option_function<std::string>(
           "--progress",
           [](const std::string& form) {
               set_progress_form(form == "json"   ? ProgressForm::json
                                 : form == "none" ? ProgressForm::off
                                                  : ProgressForm::automatic);
           },
           "Progress on standard error; auto: a bar, if that is a terminal; json: lines of JSON "
           "(docs/batch.md)")
        ->type_name("NAME")
        ->check(one_of({"auto", "json", "none"}))
        ->default_str("auto");
}

}  // namespace sightline
