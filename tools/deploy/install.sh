#!/bin/sh
# Installs flightapp on a companion computer; `make install-nuc` calls it. May be run again at any time: it replaces the program,
# the unit and the udev rules, and never touches what a person has written in /etc/flightapp.
#
#   DESTDIR=DIR           install below DIR, for a package or a test: no user is made, nothing is reloaded
#   PROGRAM=no            leave out the virtual environment
#   PIXHAWK_SERIAL=TEXT   serial number of the USB adapter on the autopilot's TELEM2, for /dev/pixhawk
set -eu

here=$(cd "$(dirname "$0")" && pwd)
source=$(cd "$here/../.." && pwd)
root=${DESTDIR:-}
program=/opt/flightapp/venv
to_do=""

fail() { echo "install-nuc: $1" >&2; exit 2; }
later() { to_do="$to_do
  - $1"; }

case "${PIXHAWK_SERIAL:-}" in *[!A-Za-z0-9_.-]*) fail "PIXHAWK_SERIAL='$PIXHAWK_SERIAL': letters, digits, '_', '.' and '-' only";; esac
[ -n "$root" ] || [ "$(id -u)" = 0 ] || fail "run it as root: sudo make install-nuc (or give DESTDIR=DIR)"

if [ -z "$root" ]; then
    getent passwd flightapp > /dev/null || useradd --system --user-group --home-dir /var/lib/flightapp --shell /usr/sbin/nologin flightapp
    install -d -o flightapp -g flightapp /var/lib/flightapp /var/cache/flightapp
fi

if [ "${PROGRAM:-yes}" = yes ]; then
    mkdir -p "$root$(dirname "$program")"
    [ -x "$root$program/bin/python" ] || python3 -m venv "$root$program"
    copy=$(mktemp -d)  # setuptools builds beside the source, and would install what an older build has left there
    trap 'rm -rf "$copy"' EXIT
    cp -r "$source/flightapp" "$source/perception" "$source/pyproject.toml" "$source/README.md" "$copy"
    PIP_CONSTRAINT="$source/requirements.txt" "$root$program/bin/python" -m pip install --quiet --disable-pip-version-check \
        "$copy[realsense]"
    "$root$program/bin/python" -m pip install --quiet --disable-pip-version-check --force-reinstall --no-deps "$copy"
    if [ -z "$root" ]; then
        (cd / && runuser -u flightapp -- env NUMBA_CACHE_DIR=/var/cache/flightapp "$program/bin/python" -m flightapp.warm_up)
    else
        later "compile the kernels as user flightapp: NUMBA_CACHE_DIR=/var/cache/flightapp $program/bin/python -m flightapp.warm_up"
    fi
fi

install -D -m 644 "$here/flightapp@.service" "$root/etc/systemd/system/flightapp@.service"
install -D -m 644 "$here/vehicle.env.example" "$root/etc/flightapp/vehicle.env.example"
if [ -n "${PIXHAWK_SERIAL:-}" ]; then
    rule="SUBSYSTEM==\"tty\", ATTRS{serial}==\"$PIXHAWK_SERIAL\", SYMLINK+=\"pixhawk\", GROUP=\"dialout\", MODE=\"0660\""
else
    rule="# (no serial number was given)"
    later "name the autopilot's adapter: sudo make install-nuc PIXHAWK_SERIAL=...; then serial:///dev/pixhawk:921600 in the profile"
fi
install -d "$root/etc/udev/rules.d"
sed "s|^# @PIXHAWK@\$|$rule|" "$here/90-flightapp.rules" > "$root/etc/udev/rules.d/90-flightapp.rules"
chmod 644 "$root/etc/udev/rules.d/90-flightapp.rules"

if [ -z "$root" ]; then
    systemctl daemon-reload
    udevadm control --reload
    udevadm trigger --subsystem-match=tty --subsystem-match=usb
fi

ls "$root"/etc/flightapp/*.env > /dev/null 2>&1 || later "write /etc/flightapp/NAME.env for the vehicle (vehicle.env.example), with mission and profile beside it"
for governor in /sys/devices/system/cpu/cpu0/cpufreq/scaling_governor; do
    [ ! -r "$governor" ] || [ "$(cat "$governor")" = performance ] || later "full clock rate at every start: sudo apt install linux-cpupower; sudo cpupower frequency-set -g performance"
done
command -v chronyc > /dev/null 2>&1 || later "one clock for all vehicles: sudo apt install chrony, one machine as server for the others"
later "check the vehicle on the ground: sudo -u flightapp $program/bin/flightapp preflight MISSION --profile PROFILE --vehicle NAME"

echo "installed in ${root:-/}: $program, flightapp@.service, udev rules. Left for a person:$to_do"
