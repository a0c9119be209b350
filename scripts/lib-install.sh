# What scripts/install and scripts/uninstall share. Both read:
#   PREFIX   where the program goes (/opt/cellctl)
#   DESTDIR  a folder to install into instead of /, for packages; no service is touched then

PREFIX=${PREFIX:-/opt/cellctl}
DESTDIR=${DESTDIR:-}
DESTDIR=${DESTDIR%/}

units=(
    cellctl.service cellctl-models.service cellctl-kiosk.service cellctl-browser@.service
    cellctl-screen.service
)
unit_folder=/etc/systemd/system
command_link=/usr/local/bin/cellctl
sysusers=/etc/sysusers.d/cellctl.conf
tmpfiles=/etc/tmpfiles.d/cellctl.conf
configuration=/etc/cellctl/cell.toml
udev_rules=/etc/udev/rules.d/70-cellctl-boards.rules
state=/var/lib/cellctl

say() { printf '%s: %s\n' "$program" "$*" >&2; }
die() { say "$*"; exit 1; }

[[ $PREFIX == /?* && $PREFIX != *[[:space:]]* ]] || die "PREFIX=$PREFIX must be an absolute path without spaces"
[[ -z $DESTDIR || $DESTDIR == /* ]] || die "DESTDIR=$DESTDIR must be an absolute path"

# Whether this machine's own services are concerned.
live() { [[ -z $DESTDIR && -d /run/systemd/system ]]; }

need_root() {
    [[ -n $DESTDIR || $(id -u) == 0 ]] || die "must run as root: sudo make $program"
}

# Refuse while a build is under way: the half-built object and the part in the gripper need the
# daemon that knows of them.
refuse_mid_build() {
    local cellctl=$DESTDIR$PREFIX/venv/bin/cellctl answer state
    live && [[ -x $cellctl ]] || return 0
    if ! systemctl --quiet is-active cellctl.service; then
        # Nothing runs, and yet a build may be half done.
        answer=$("$cellctl" history --limit 1 --json 2>/dev/null) || return 0
        state=$(printf '%s' "$answer" | "$DESTDIR$PREFIX/venv/bin/python" -c '
import json, sys
jobs = json.load(sys.stdin)
print("yes" if jobs and not jobs[0]["finished_at"] else "")')
        [[ -z $state ]] ||
            die "refused: a job is half done. Start the daemon and finish it, or: cellctl cancel"
        return 0
    fi
    answer=$("$cellctl" status --json) ||
        die "the daemon runs but does not answer; stop it first: systemctl stop cellctl"
    state=$(printf '%s' "$answer" | "$DESTDIR$PREFIX/venv/bin/python" -c '
import json, sys
snapshot = json.load(sys.stdin)
job = snapshot["job"]
under_way = job is not None and not job["outcome"]
print(snapshot["state"]["state"] if under_way else "")')
    [[ -z $state ]] ||
        die "refused: a job is under way ($state). Let it finish, or: cellctl cancel"
}
