"""The names of Python's library that CPython lacks on Windows, by module."""

_OS = """
    fork forkpty getuid geteuid getgid getegid getgroups setsid setpgid getpgid getpgrp killpg
    memfd_create pread pwrite preadv pwritev mkfifo mknod chown fchown lchown chroot uname sysconf
    sysconf_names confstr getloadavg nice sched_getaffinity sched_setaffinity sched_yield statvfs
    fstatvfs pipe2 eventfd copy_file_range sendfile register_at_fork sync wait wait3 wait4 waitid
    WNOHANG WIFEXITED WEXITSTATUS WIFSIGNALED WTERMSIG O_NOFOLLOW O_NONBLOCK O_CLOEXEC O_SYNC
    O_DIRECTORY O_PATH O_TMPFILE getresuid ttyname ctermid openpty posix_fadvise posix_fallocate
    posix_spawn lockf F_LOCK fdatasync getxattr setxattr listxattr removexattr getrandom pidfd_open
    fchdir
""".split()
_SIGNAL = """
    SIGKILL SIGHUP SIGCHLD SIGCLD SIGSTOP SIGTSTP SIGCONT SIGXCPU SIGXFSZ SIGALRM SIGVTALRM SIGPROF
    SIGBUS SIGPIPE SIGUSR1 SIGUSR2 SIGQUIT SIGTRAP SIGSYS SIGURG SIGIO SIGPOLL SIGPWR SIGTTIN
    SIGTTOU SIGWINCH SIGRTMIN SIGRTMAX alarm pause setitimer getitimer ITIMER_REAL sigwait
    sigwaitinfo sigtimedwait pthread_sigmask pthread_kill siginterrupt sigpending SIG_BLOCK
    SIG_UNBLOCK SIG_SETMASK
""".split()
_SOCKET = "AF_UNIX SO_REUSEPORT MSG_DONTWAIT MSG_NOSIGNAL AF_NETLINK AF_PACKET CMSG_LEN".split()
LACKING = {"os": frozenset(_OS), "signal": frozenset(_SIGNAL), "socket": frozenset(_SOCKET)}
LACKING_BEFORE_3_12 = {"os": frozenset({"set_blocking", "get_blocking", "fchmod"})}
MISSING_MODULES = frozenset(
    {"fcntl", "resource", "pwd", "grp", "termios", "tty", "pty", "syslog", "posix", "readline"}
)
