// Loops that the preprocessor writes out: EACH_4(DO) becomes DO(0) DO(1) DO(2) DO(3). EACH_POLE does this for all
// POLES, EACH_PIXEL for all pixels of a BLOCK, and EACH_PIXEL_BACK for these pixels from the last to the first.
//
// They serve for loops whose index selects from a local array, and for loops inside loops over pixels. Mesa's llvmpipe
// does not unroll a large loop, and reads an array by a varying index one lane at a time. To be safe from endless
// shaders it also stops every loop of an invocation after 65535 iterations in all.

#define EACH_1(DO) DO(0)
#define EACH_2(DO) EACH_1(DO) DO(1)
#define EACH_3(DO) EACH_2(DO) DO(2)
#define EACH_4(DO) EACH_3(DO) DO(3)
#define EACH_5(DO) EACH_4(DO) DO(4)
#define EACH_6(DO) EACH_5(DO) DO(5)
#define EACH_8(DO) EACH_6(DO) DO(6) DO(7)

#define EACH_2_BACK(DO) DO(1) DO(0)
#define EACH_4_BACK(DO) DO(3) DO(2) EACH_2_BACK(DO)
#define EACH_8_BACK(DO) DO(7) DO(6) DO(5) DO(4) EACH_4_BACK(DO)

#if POLES == 1
#define EACH_POLE EACH_1
#elif POLES == 2
#define EACH_POLE EACH_2
#elif POLES == 3
#define EACH_POLE EACH_3
#elif POLES == 4
#define EACH_POLE EACH_4
#elif POLES == 5
#define EACH_POLE EACH_5
#elif POLES == 6
#define EACH_POLE EACH_6
#endif

#if BLOCK == 2
#define EACH_PIXEL EACH_2
#define EACH_PIXEL_BACK EACH_2_BACK
#elif BLOCK == 4
#define EACH_PIXEL EACH_4
#define EACH_PIXEL_BACK EACH_4_BACK
#elif BLOCK == 8
#define EACH_PIXEL EACH_8
#define EACH_PIXEL_BACK EACH_8_BACK
#endif
