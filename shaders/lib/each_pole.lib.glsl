// EACH_POLE(DO): DO(0) DO(1) ... DO(POLES - 1), written out by the preprocessor.
//
// For loops over poles inside loops over pixels whose body is large. Mesa's llvmpipe leaves such a
// loop rolled and, to be safe from endless shaders, stops every loop of an invocation after 65535
// iterations in all: a line of 8192 pixels with 5 poles would end early, without an error.

#define EACH_POLE_1(DO) DO(0)
#define EACH_POLE_2(DO) EACH_POLE_1(DO) DO(1)
#define EACH_POLE_3(DO) EACH_POLE_2(DO) DO(2)
#define EACH_POLE_4(DO) EACH_POLE_3(DO) DO(3)
#define EACH_POLE_5(DO) EACH_POLE_4(DO) DO(4)
#define EACH_POLE_6(DO) EACH_POLE_5(DO) DO(5)

#if POLES == 1
#define EACH_POLE EACH_POLE_1
#elif POLES == 2
#define EACH_POLE EACH_POLE_2
#elif POLES == 3
#define EACH_POLE EACH_POLE_3
#elif POLES == 4
#define EACH_POLE EACH_POLE_4
#elif POLES == 5
#define EACH_POLE EACH_POLE_5
#elif POLES == 6
#define EACH_POLE EACH_POLE_6
#endif
