/* What Windows calls when it loads a library that has no C runtime: there is nothing to prepare. */
int __stdcall DllMainCRTStartup(void *library, unsigned long reason, void *reserved);

int __stdcall DllMainCRTStartup(void *library, unsigned long reason, void *reserved) {
    (void)library, (void)reason, (void)reserved;
    return 1;
}
