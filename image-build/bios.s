# What a BIOS starts of the disk: it shows a sentence and halts. Without it a computer that starts by BIOS or Legacy (CSM)
# shows a blinking cursor, and nothing says why.
#
# It is the boot code of the protective MBR: 440 bytes at most, which UEFI does not use. `bios-program` assembles it.
        .code16
        .globl start
start:
        cli
        xorw %ax, %ax
        movw %ax, %ds
        movw %ax, %ss
        movw $0x7c00, %sp
        sti
        cld
# Text of 80 columns and 25 rows, empty.
        movw $0x0003, %ax
        int $0x10
# No cursor.
        movb $0x01, %ah
        movw $0x2000, %cx
        int $0x10
        movw $text, %si
next:
        lodsb
        testb %al, %al
        jz halt
        movb $0x0e, %ah
        movw $0x0007, %bx
        int $0x10
        jmp next
halt:
        hlt
        jmp halt
text:
        .ascii "This picture starts with UEFI only.\r\n"
        .asciz "In the settings of this computer's firmware, switch from BIOS or Legacy to UEFI."
