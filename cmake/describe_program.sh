#!/bin/bash
# Man pages and completion for bash, made from what a program says with --help.
#   cmake/describe_program.sh PROGRAM FOLDER
# writes FOLDER/man/NAME.1.gz, one NAME-SUBCOMMAND.1.gz for each subcommand, and FOLDER/completions/NAME.
set -euo pipefail
program=$1 folder=$2
name=$(basename "$program")
version=$("$program" --version 2>/dev/null || printf '%s' "$name")
rm -rf "$folder"
mkdir -p "$folder/man" "$folder/completions"

# A help text as a man page. CLI11 gives: what it is (the line with neither blank in front nor colon at
# the end; examples around it), "Usage: ...", then groups of "  name ARGUMENT   what it does", of which
# the second part begins in column 31 and may be on the next lines.
man_page() { # NAME-OF-PAGE SEE-ALSO
  awk -v page="$1" -v see="$2" -v version="$version" '
    function text(s) {
      gsub(/\\/, "\\e", s); gsub(/-/, "\\-", s)
      if (s ~ /^[.\x27]/) s = "\\&" s
      return s
    }
    function flush_item() {
      if (item == "") return
      print ".TP\n\\fB" text(item) "\\fR"
      if (what != "") print text(what)
      item = what = ""
    }
    /^Usage: / && !usage { usage = substr($0, 8); next }
    !usage {
      if (summary == "" && $0 !~ /^ / && $0 !~ /:$/ && $0 != "") { summary = $0; sub(/\.$/, "", summary) }
      else intro[++n] = $0
      next
    }
    !started {
      started = 1
      print ".TH \"" toupper(page) "\" 1 \"\" \"" version "\""
      print ".SH NAME\n" text(page) " \\- " text(summary)
      print ".SH SYNOPSIS\n" text(usage)
      for (i = 1; i <= n; ++i) if (intro[i] ~ /[^ ]/) any = 1
      if (any) {
        print ".SH DESCRIPTION\n.nf"
        for (i = 1; i <= n; ++i) print text(intro[i])
        print ".fi"
      }
    }
    /^[A-Za-z].*:$/ {
      flush_item()
      group = toupper(substr($0, 1, length($0) - 1))
      if (group == "POSITIONALS") group = "ARGUMENTS"
      print ".SH " group
      next
    }
    /^  [^ ]/ {
      flush_item()
      item = substr($0, 3)
      sub(/,--/, ", --", item)
      if (match(item, /   *[^ ]/) && RSTART + RLENGTH >= 30) {
        what = substr(item, RSTART + RLENGTH - 1)
        item = substr(item, 1, RSTART - 1)
      }
      next
    }
    # Of a subcommand the first line: it has a page of its own.
    /[^ ]/ && !(group == "SUBCOMMANDS" && what != "") {
      sub(/^ */, "")
      what = (what == "" ? $0 : what " " $0)
    }
    END { flush_item(); if (see != "") print ".SH SEE ALSO\n" text(see) }'
}

# Settings for --set: lines of a role and a key, and which roles' each subcommand takes.
keys=''
if "$program" --help | grep -q '^  plugins '; then keys=$("$program" plugins --keys); fi
roles_of() { # WORDS OF THE SUBCOMMAND
  case "$*" in
    run) echo 'estimator rendezvous source' ;;
    record) echo 'estimator rendezvous live' ;;
    rendezvous) echo 'estimator rendezvous' ;;
    'calibrate camera') echo 'estimator' ;;
    import | check) echo 'source' ;;
    simulate) echo 'simulator' ;;
  esac
}
key_lists() {
  local role
  for role in $(cut -d ' ' -f 1 <<<"$keys" | sort -u); do
    printf "    '%s') keys='%s' ;;\n" "$role" "$(sed -n "s/^$role //p" <<<"$keys" | tr '\n' ' ')"
  done
}

# The completion: what may follow each (sub)command, and the values of options that name theirs.
follows='' values=''
describe() { # WORDS OF THE SUBCOMMAND
  local help subs options sub pages='' words=$* page
  help=$("$program" "$@" --help)
  subs=$(sed -n '/^Subcommands:/,$s/^  \([a-z][a-z-]*\)\( .*\)\{0,1\}$/\1/p' <<<"$help")
  options=$(sed -n '/^Usage:/,$s/^  \(-[^ ]*\).*/\1/p' <<<"$help" | tr ',' '\n' | grep '^--' | tr '\n' ' ' || true)
  for sub in $subs; do pages+="${pages:+, }$name${words:+-${words// /-}}-$sub(1)"; done
  page=$name${words:+-${words// /-}}
  man_page "$page" "${words:+$name(1)${pages:+, }}$pages" <<<"$help" | gzip -9n >"$folder/man/$page.1.gz"
  follows+="    '$words') subcommands='${subs//$'\n'/ }' options='${options% }' ;;"$'\n'
  values+=$(sed -n "s/^  \(-[^ ]*\) [^ ]*:{\([^}]*\)}.*/\1 \2/p" <<<"$help" | while read -r option list; do
    for alias in ${option//,/ }; do printf "    '%s %s') values='%s' ;;\n." "$words" "$alias" "${list//,/ }"; done
  done | tr -d '.')
  if [[ " $options" == *' --set '* ]] && [ -n "$keys" ]; then
    values+="    '$words --set') roles='$(roles_of "$@")' ;;"$'\n'
  fi
  for sub in $subs; do describe "$@" "$sub"; done
}
describe

function_name=_${name//-/_}
cat >"$folder/completions/$name" <<END
# Completion for $name in bash; made from its --help when it was built.
$function_name() {
  local cur=\${COMP_WORDS[COMP_CWORD]} prev=\${COMP_WORDS[COMP_CWORD - 1]}
  local path='' subcommands options values='' roles='' keys i word
  # bash splits --option=value into three words.
  [ "\$cur" = '=' ] && cur=''
  [ "\$prev" = '=' ] && prev=\${COMP_WORDS[COMP_CWORD - 2]}
  COMPREPLY=()
  ${function_name}_follows
  local global=\$options
  for ((i = 1; i < COMP_CWORD; ++i)); do
    word=\${COMP_WORDS[i]}
    [[ " \$subcommands " == *" \$word "* ]] || continue
    path+="\${path:+ }\$word"
    ${function_name}_follows
  done
  case "\$path \$prev" in
$values
  esac
  if [ -n "\$roles" ]; then
    for word in \$roles; do
      ${function_name}_keys "\$word"
      mapfile -t -O \${#COMPREPLY[@]} COMPREPLY < <(compgen -S = -W "\$keys" -- "\$cur")
    done
    compopt -o nospace 2>/dev/null || true
  elif [ -n "\$values" ]; then
    mapfile -t COMPREPLY < <(compgen -W "\$values" -- "\$cur")
  elif [[ \$cur == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "\$options \$global" -- "\$cur" | sort -u)
  elif [[ \$prev != -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "\$subcommands" -- "\$cur")
  fi
}
${function_name}_follows() {
  case "\$path" in
$follows  esac
}
${function_name}_keys() {
  keys=''
  case "\$1" in
$(key_lists)
  esac
}
complete -o default -F $function_name $name
END
