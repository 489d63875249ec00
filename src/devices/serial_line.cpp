// termios.h knows the usual rates only, and RPLIDARs have 256000 baud: this is Linux's own
// interface to terminals, which can't be included beside it.
#include <asm/termbits.h>
#include <sys/ioctl.h>

#include "devices/wire.hpp"

namespace loopstone {

bool make_raw_line(int descriptor, int baud) {
  termios2 line{};
  if (::ioctl(descriptor, TCGETS2, &line) != 0) return false;
  line.c_iflag = 0;
  line.c_oflag = 0;
  line.c_lflag = 0;
  line.c_cflag = BOTHER | CS8 | CREAD | CLOCAL;
  line.c_ispeed = static_cast<speed_t>(baud);
  line.c_ospeed = static_cast<speed_t>(baud);
  line.c_cc[VMIN] = 1;
  line.c_cc[VTIME] = 0;
  if (::ioctl(descriptor, TCSETS2, &line) != 0) return false;
  return ::ioctl(descriptor, TCFLSH, TCIFLUSH) == 0;
}

}  // namespace loopstone
