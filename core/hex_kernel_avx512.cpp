#include "core/hex_kernel_body.h"
