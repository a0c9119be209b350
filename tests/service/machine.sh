# A machine of its own with systemd as its first process: namespaces over a copy-on-write view of
# this system. Nothing that happens in it reaches this one. Needs root. Arguments: the folder with
# what `make install` laid out, this repository, the folder of site-packages, a Python.
set -euo pipefail
PATH=$PATH:/usr/sbin:/sbin # pivot_root lives there
installed=$1 repository=$2 packages=$3 python=$4

mount --make-rprivate /
work=$(dirname "$installed")/machine
mkdir -p "$work"
mount -t tmpfs tmpfs "$work"
mkdir "$work"/{upper,scratch,root,site,site-scratch}
mount -t overlay overlay -o "lowerdir=/,upperdir=$work/upper,workdir=$work/scratch" "$work/root"
root=$work/root
cp -R "$installed/." "$root/"
venv=$root/opt/cellctl/venv
version=$(basename "$python")
rm -rf "$venv"
mkdir -p "$venv/bin" "$venv/lib/$version/site-packages"
ln -s "$python" "$venv/bin/python"
printf 'home = /usr/bin\n' >"$venv/pyvenv.cfg"
printf '%s\n' '#!/opt/cellctl/venv/bin/python' 'from cellctl.cli.app import main' \
    'if __name__ == "__main__":' '    main()' >"$venv/bin/cellctl"
chmod +x "$venv/bin/cellctl"
cp -R "$repository/cellctl" "$work/site/"
mount -t overlay overlay \
    -o "lowerdir=$packages,upperdir=$work/site,workdir=$work/site-scratch" \
    "$venv/lib/$version/site-packages"

mount -t proc proc "$root/proc"
mount --bind "$root/proc/sys" "$root/proc/sys"
mount -o remount,bind,ro "$root/proc/sys"
mount -t sysfs -o ro sysfs "$root/sys"
mount -t cgroup2 cgroup2 "$root/sys/fs/cgroup"
mount -t tmpfs -o mode=755 tmpfs "$root/dev"
for name in null zero full random urandom tty; do
    touch "$root/dev/$name"
    mount --bind "/dev/$name" "$root/dev/$name"
done
mknod -m 0666 "$root/dev/tty0" c 4 0 # a device that the daemon has no business with
mkdir "$root/dev/pts" "$root/dev/shm"
mount -t devpts -o newinstance,ptmxmode=0666,mode=620 devpts "$root/dev/pts"
ln -s pts/ptmx "$root/dev/ptmx"
ln -s /proc/self/fd "$root/dev/fd"
mount -t tmpfs -o mode=1777 tmpfs "$root/dev/shm"
mount -t tmpfs -o mode=755 tmpfs "$root/run"
mount -t tmpfs -o mode=1777 tmpfs "$root/tmp"
ip link set lo up
ip address add 192.168.7.7/32 dev lo # the robot's, of a private range
ip address add 203.0.113.7/32 dev lo # the internet's (RFC 5737)

ln -sf /dev/null "$root/etc/systemd/system/modprobe@.service"
printf '[Unit]\nAllowIsolate=yes\n' >"$root/etc/systemd/system/bare.target"
mkdir -p "$root/old"
cd "$root"
pivot_root . old
umount -l /old
exec env -i PATH=/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin container=cellctl-test \
    /lib/systemd/systemd --system --unit=bare.target --log-target=console --show-status=no \
    --default-standard-output=inherit
