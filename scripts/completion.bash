# SPDX-License-Identifier: GPL-3.0-or-later
# Completion for bash: options that --help names, the words that it lists for an option's WORD or
# FORMAT, else files.

# The words for option $2 of program $1: "auto (default: ...), lumped or consistent" without what is
# in brackets. The list stands behind the option or in the next line.
_cbr_words() {
  "$1" --help 2>/dev/null | awk -v option="$2" '
    wanted { print; exit }
    { for (i = 1; i < NF; ++i) if ($i == option && $(i + 1) ~ /^(WORD|FORMAT)/) {
        text = $0
        sub(".*" option " (WORD|FORMAT)", "", text)
        if (text ~ /^:[{]/) { gsub(/[:{}]/, "", text); sub(/ .*/, "", text); gsub(/,/, ", ", text) }
        sub(/ *(Excludes|Needs):.*/, "", text)
        if (text ~ /[a-z]/) { print text; exit }
        wanted = 1
        break
      }
    }' | sed -E 's/\([^()]*\)//g; s/;.*//; s/^.*: //; s/ or /,/g' | tr ',' '\n' |
    awk '$1 ~ /^[a-z][a-z0-9-]*$/ { print $1 }'
}

_cbr() {
  local program=${COMP_WORDS[0]} word=${COMP_WORDS[COMP_CWORD]} before="" words=""
  ((COMP_CWORD > 0)) && before=${COMP_WORDS[COMP_CWORD - 1]}
  [[ $before == --* ]] && words=$(_cbr_words "$program" "$before")
  if [[ $words ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")
  elif [[ $word == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$("$program" --help 2>/dev/null | grep -oE '(^|[ ,[])--?[a-z][a-z-]*' | tr -d ' ,[' | sort -u)" -- "$word")
  else
    compopt -o filenames 2>/dev/null
    mapfile -t COMPREPLY < <(compgen -f -- "$word")
  fi
}
complete -F _cbr cbr-reduce cbr-skin cbr-dyn cbr-report
