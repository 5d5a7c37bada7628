// Names that engines, systems and toolkits define as macros, as text that no compiler takes.
#pragma once

// <windows.h>
#undef small
#define small a macro named small is used
#undef near
#define near a macro named near is used
#undef far
#define far a macro named far is used
#undef interface
#define interface a macro named interface is used
#undef IN
#define IN a macro named IN is used
#undef OUT
#define OUT a macro named OUT is used
#undef ERROR
#define ERROR a macro named ERROR is used
#undef TRUE
#define TRUE a macro named TRUE is used
#undef FALSE
#define FALSE a macro named FALSE is used
#undef DELETE
#define DELETE a macro named DELETE is used
#undef CONST
#define CONST a macro named CONST is used
#undef VOID
#define VOID a macro named VOID is used
#undef OPTIONAL
#define OPTIONAL a macro named OPTIONAL is used
#undef STRICT
#define STRICT a macro named STRICT is used
#undef ABSOLUTE
#define ABSOLUTE a macro named ABSOLUTE is used
#undef RELATIVE
#define RELATIVE a macro named RELATIVE is used
#undef TRANSPARENT
#define TRANSPARENT a macro named TRANSPARENT is used
#undef OPAQUE
#define OPAQUE a macro named OPAQUE is used
#undef INFINITE
#define INFINITE a macro named INFINITE is used
#undef NO_ERROR
#define NO_ERROR a macro named NO_ERROR is used
#undef CALLBACK
#define CALLBACK a macro named CALLBACK is used
#undef THIS
#define THIS a macro named THIS is used
#undef min
#define min a macro named min is used
#undef max
#define max a macro named max is used
// <X11/Xlib.h>
#undef Bool
#define Bool a macro named Bool is used
#undef Status
#define Status a macro named Status is used
#undef None
#define None a macro named None is used
#undef Always
#define Always a macro named Always is used
#undef Never
#define Never a macro named Never is used
#undef Success
#define Success a macro named Success is used
#undef True
#define True a macro named True is used
#undef False
#define False a macro named False is used
#undef Above
#define Above a macro named Above is used
#undef Below
#define Below a macro named Below is used
#undef Unsorted
#define Unsorted a macro named Unsorted is used
#undef Complex
#define Complex a macro named Complex is used
#undef Convex
#define Convex a macro named Convex is used
#undef KeyPress
#define KeyPress a macro named KeyPress is used
#undef Expose
#define Expose a macro named Expose is used
#undef FocusIn
#define FocusIn a macro named FocusIn is used
#undef FocusOut
#define FocusOut a macro named FocusOut is used
#undef CursorShape
#define CursorShape a macro named CursorShape is used
// Unreal Engine and its like
#undef check
#define check a macro named check is used
#undef verify
#define verify a macro named verify is used
#undef ensure
#define ensure a macro named ensure is used
#undef PI
#define PI a macro named PI is used
#undef TEXT
#define TEXT a macro named TEXT is used
#undef INLINE
#define INLINE a macro named INLINE is used
#undef FORCEINLINE
#define FORCEINLINE a macro named FORCEINLINE is used
// Qt
#undef emit
#define emit a macro named emit is used
#undef signals
#define signals a macro named signals is used
#undef slots
#define slots a macro named slots is used
#undef foreach
#define foreach a macro named foreach is used
#undef forever
#define forever a macro named forever is used
// C
#undef assert
#define assert a macro named assert is used
#undef I
#define I a macro named I is used
#undef major
#define major a macro named major is used
#undef minor
#define minor a macro named minor is used
#undef unix
#define unix a macro named unix is used
#undef linux
#define linux a macro named linux is used
#undef MIN
#define MIN a macro named MIN is used
#undef MAX
#define MAX a macro named MAX is used
#undef ABS
#define ABS a macro named ABS is used
#undef CLAMP
#define CLAMP a macro named CLAMP is used
