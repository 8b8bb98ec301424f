# SPDX-License-Identifier: MIT
# bash completion of alidade, which knows its words itself.
_alidade() {
  local answer current=${COMP_WORDS[COMP_CWORD]#=}
  COMPREPLY=()
  answer=$("${COMP_WORDS[0]/#\~/$HOME}" complete "${COMP_WORDS[@]:1:COMP_CWORD}" 2>/dev/null)
  case $answer in
    :file) compopt -o default ;;
    :folder) compopt -o dirnames ;;
    *) mapfile -t COMPREPLY < <(compgen -W "$(cut -f 1 <<<"$answer")" -- "$current") ;;
  esac
} && complete -F _alidade alidade
