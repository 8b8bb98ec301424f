# SPDX-License-Identifier: MIT
# fish completion of alidade, which knows its words itself.
function __alidade_complete
    set -l words (commandline -opc)
    set -l current (commandline -ct)
    set -l answer ($words[1] complete $words[2..-1] "$current" 2>/dev/null)
    switch "$answer"
        case :file
            __fish_complete_path "$current"
        case :folder
            __fish_complete_directories "$current" ''
        case '*'
            printf '%s\n' $answer
    end
end
complete -c alidade -f -a '(__alidade_complete)'
