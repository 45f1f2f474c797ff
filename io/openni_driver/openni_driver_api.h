// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/** \file
 * OpenNI2's interface of drivers, which uses macros of a library that is not installed. */

#ifndef FALSE
#define FALSE 0
#endif
#ifndef TRUE
#define TRUE 1
#endif
#define XN_NEW(Type, ...) new Type(__VA_ARGS__)
#define XN_DELETE(pointer) delete (pointer)
#include <Driver/OniDriverAPI.h>
