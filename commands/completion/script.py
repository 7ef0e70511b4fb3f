"""The bash side of completion: asks ./run for candidates, and knows nothing of commands itself."""

# bash splits words at the ':' and '=' of NAME:=VALUE, so the whole line is handed over, and the
# candidates come back as what stands behind the last of these characters.
SCRIPT = r"""# Completion of Paddock's ./run, for ~/.bashrc: source <(PATH_OF_CLONE/run completion)
_paddock_run() {
  local program candidates
  COMPREPLY=()
  program=$(readlink -f -- "${1/#\~/$HOME}") || return
  if [ ! -e "${program%/*}/commands/table.py" ]; then return; fi
  candidates=$("$program" completion --line "${COMP_LINE:0:COMP_POINT}" \
    --breaks "$COMP_WORDBREAKS" 2>/dev/null) || return
  case $candidates in
    '') ;;
    @commands) mapfile -t COMPREPLY < <(compgen -c -- "$2" | sort -u) ;;
    *) mapfile -t COMPREPLY <<<"$candidates" ;;
  esac
  case ${COMPREPLY[0]:-} in *=) compopt -o nospace 2>/dev/null ;; esac
}
complete -o bashdefault -o default -F _paddock_run run
"""
