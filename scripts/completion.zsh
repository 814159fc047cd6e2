#compdef cbr-reduce cbr-skin cbr-dyn cbr-report
# SPDX-License-Identifier: GPL-3.0-or-later
# Completion for zsh: options that --help names, else files.
_arguments -- '*:file:_files'
