#!/bin/sh
# Installs those of the Debian packages named in the file $1 that are missing: as root with apt-get, otherwise through
# sudo; where neither can be, says which to install and ends with 3.
set -eu
list=$1
missing=
while read -r package; do
  state=$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null) || state=absent
  [ "$state" = installed ] || missing="$missing $package"
done <"$list"
[ -n "$missing" ] || exit 0
# Quiet, but what went wrong is seen.
# shellcheck disable=SC2086  # the names are words
install() {
  echo "installing Debian packages:$missing"
  "$@" apt-get update -qq
  "$@" env DEBIAN_FRONTEND=noninteractive apt-get install -qq -y --no-install-recommends $missing >/dev/null
}
if [ "$(id -u)" = 0 ]; then
  install
elif command -v sudo >/dev/null 2>&1 && { sudo -n true 2>/dev/null || [ -t 0 ]; }; then
  install sudo
else
  echo "these Debian packages are missing; install them as root, then run make again:" >&2
  echo "  apt-get install$missing" >&2
  exit 3
fi
